#include "ui/workstation/view/picture_view.h"

#include "tests/ui/scene/sample_scenes.h"

#include <gtest/gtest.h>

#include <QTest>

#include <vector>

namespace retractor::ui {
namespace picture_view_test {

    constexpr int kWidth = 400, kHeight = 300;

    TEST(PictureView, SideBySideTheMouseMeansTheSameInBothHalves)
    {
        PictureView view;
        view.resize(kWidth, kHeight);
        view.show_scenes({ samples::little_chest(false) });
        view.show();
        ASSERT_TRUE(QTest::qWaitForWindowExposed(&view));
        std::vector<QPointF> clicked;
        ClickTool tool([&](const QPointF& at) { clicked.push_back(at); });
        view.set_tool(&tool);
        const QPoint left(50, 100), right(50 + kWidth / 2, 100);
        QTest::mouseClick(&view, Qt::LeftButton, Qt::NoModifier, left);
        view.set_stereo(Stereo::side_by_side);
        QTest::mouseClick(&view, Qt::LeftButton, Qt::NoModifier, left);
        QTest::mouseClick(&view, Qt::LeftButton, Qt::NoModifier, right);
        view.set_stereo(Stereo::lines);
        QTest::mouseClick(&view, Qt::LeftButton, Qt::NoModifier, right);
        view.set_tool(nullptr);
        ASSERT_EQ(clicked.size(), 4U);
        EXPECT_EQ(clicked[0], QPointF(50.0, 100.0));
        EXPECT_EQ(clicked[1], QPointF(100.0, 100.0)) << "the half is stretched to the whole";
        EXPECT_EQ(clicked[2], QPointF(100.0, 100.0));
        EXPECT_EQ(clicked[3], QPointF(right));
    }

} // namespace picture_view_test
} // namespace retractor::ui
