#include "ui/workstation/view/moving_resolution.h"

#include <gtest/gtest.h>

#include <cmath>

namespace retractor::ui {
namespace moving_resolution_test {

    constexpr int kMany = 100;

    /// Draws on a machine on which all pixels of the screen take so long, beside what every picture takes.
    void draw(MovingResolution& resolution, double pixels_ms, double base_ms)
    {
        for (int i = 0; i < kMany; ++i)
            resolution.drawn(base_ms + pixels_ms * std::pow(resolution.scale(), 2));
    }

    TEST(MovingResolution, StaysFineWhereDrawingIsQuick)
    {
        MovingResolution resolution;
        draw(resolution, 20.0, 5.0);
        EXPECT_FALSE(resolution.rested());
        EXPECT_EQ(resolution.scale(), 1.0);
    }

    TEST(MovingResolution, GoesDownUntilPicturesComeInTime)
    {
        MovingResolution resolution;
        draw(resolution, 45.0, 5.0);
        EXPECT_NEAR(resolution.scale(), 1.0 / std::sqrt(2.0), 1e-12); // 28 ms with half the pixels
        draw(resolution, 45.0, 5.0);
        EXPECT_NEAR(resolution.scale(), 1.0 / std::sqrt(2.0), 1e-12);
        draw(resolution, 1000.0, 100.0);
        EXPECT_NEAR(resolution.scale(), 0.5, 1e-12); // and no further
    }

    TEST(MovingResolution, BeginsWithWhatADrawingTakes)
    {
        MovingResolution quick, slow;
        EXPECT_FALSE(quick.begin(30.0));
        EXPECT_EQ(quick.scale(), 1.0);
        EXPECT_TRUE(slow.begin(64.0));
        EXPECT_NEAR(slow.scale(), 5.0 / 8.0, 1e-12);
    }

    TEST(MovingResolution, OneSlowDrawingChangesNothing)
    {
        MovingResolution resolution;
        for (int i = 0; i < kMany; ++i)
            EXPECT_FALSE(resolution.drawn(i % 4 == 0 ? 500.0 : 30.0));
    }

    TEST(MovingResolution, IsFineAgainAfterRestsOnAMachineThatIsFree)
    {
        MovingResolution resolution;
        draw(resolution, 400.0, 0.0);
        ASSERT_EQ(resolution.scale(), 0.5);
        int rests = 0;
        for (bool changed = true; changed && rests < kMany; ++rests) {
            draw(resolution, 8.0, 2.0);
            changed = resolution.rested();
        }
        EXPECT_EQ(resolution.scale(), 1.0);
        // A rest without a motion before it says nothing about the machine.
        EXPECT_FALSE(MovingResolution().rested());
    }

} // namespace moving_resolution_test
} // namespace retractor::ui
