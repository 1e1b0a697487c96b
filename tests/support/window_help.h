#pragma once
// Waiting in the tests of windows: for what is to come, never for a time that a busy machine may exceed.

#include "ui/workstation/view/picture_view.h"

#include <gtest/gtest.h>

#include <QApplication>
#include <QTest>

namespace retractor::test_support {

inline constexpr int kPatienceMs = 120000; // a busy machine

/// Shows a window and waits until its picture can be drawn.
template <class Window> void show_window(Window& window)
{
    window.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, kPatienceMs));
    QApplication::setActiveWindow(&window);
    ASSERT_TRUE(QTest::qWaitFor([&] { return window.view().ready(); }, kPatienceMs));
}

/// Waits until the window has nothing to do and has shown all that its threads have told it.
template <class Window> void wait_until_idle(Window& window)
{
    const auto idle = [&] { return window.idle(); };
    ASSERT_TRUE(QTest::qWaitFor(idle, kPatienceMs));
    QCoreApplication::processEvents(); // what was posted before the window was idle
    ASSERT_TRUE(QTest::qWaitFor(idle, kPatienceMs));
}

} // namespace retractor::test_support
