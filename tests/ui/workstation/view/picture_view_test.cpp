#include "ui/workstation/view/picture_view.h"

#include "tests/ui/scene/sample_scenes.h"

#include <gtest/gtest.h>

#include <QTest>

#include <algorithm>
#include <vector>

namespace retractor::ui {
namespace picture_view_test {

    constexpr int kWidth = 400, kHeight = 300;

    /// @return the share of the width that the title's letters take; 0: no letters
    double title_width(const QImage& picture)
    {
        constexpr double kTitleRows = 0.12;
        constexpr int kInk = 215; // of 255: letters are lighter than all else
        int last = 0;
        for (int y = 0; y < kTitleRows * picture.height(); ++y)
            for (int x = 0; x < picture.width(); ++x)
                if (qGray(picture.pixel(x, y)) > kInk)
                    last = std::max(last, x);
        return static_cast<double>(last) / picture.width();
    }

    TEST(PictureView, LettersOfTheMovingPictureAreAsLargeAsThoseOfTheFullOne)
    {
        PictureView view;
        view.resize(kWidth, kHeight);
        QImage full;
        view.on_full_picture = [&](const QImage& image) { full = image; };
        Scene scene = samples::little_chest(false);
        scene.title = "Letters";
        view.show_scenes({ scene });
        view.show();
        ASSERT_TRUE(QTest::qWaitForWindowExposed(&view));
        ASSERT_TRUE(QTest::qWaitFor([&] { return !full.isNull(); }, 30'000));
        const double moving = title_width(view.grabFramebuffer()), resting = title_width(full);
        EXPECT_GT(resting, 0.1);
        EXPECT_NEAR(moving, resting, 0.03) << "at " << view.devicePixelRatioF() << " pixels of the screen a point";
    }

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
