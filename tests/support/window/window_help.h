#pragma once
// Functions that wait in the tests of windows. They wait for an event, not for a fixed time, which a busy machine may
// exceed.

#include "ui/workstation/view/picture_view.h"

#include <gtest/gtest.h>

#include <QApplication>
#include <QTest>

namespace retractor::test_support {

inline constexpr int kPatienceMs = 600000; // limit for a busy machine, and for sanitizers

/// Whether the window's picture can be drawn, or is not shown.
template <class Window> bool picture_ready(Window& window)
{
    return !window.view().isVisible() || window.view().ready();
}

/// Shows a window and waits until the window can draw its picture, where it shows one.
template <class Window> void show_window(Window& window)
{
    window.show();
    ASSERT_TRUE(QTest::qWaitForWindowExposed(&window, kPatienceMs));
    QApplication::setActiveWindow(&window);
    ASSERT_TRUE(QTest::qWaitFor([&] { return picture_ready(window); }, kPatienceMs));
}

/// Waits until the window is idle and has shown all results of its threads.
template <class Window> void wait_until_idle(Window& window)
{
    const auto idle = [&] { return window.idle() && picture_ready(window); };
    ASSERT_TRUE(QTest::qWaitFor(idle, kPatienceMs));
    QCoreApplication::processEvents(); // events posted before the window was idle
    ASSERT_TRUE(QTest::qWaitFor(idle, kPatienceMs));
}

} // namespace retractor::test_support
