#include "haptics/hand_model.h"

#include "haptics/surface_locator.h"
#include "tests/haptics/test_help.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

using namespace retractor;

TEST(HandModel, isAClosedHandWithItsTipsInside)
{
    const HandModel hand = make_hand(false);
    const SurfaceLocator surface(hand.surface);
    for (const Vec3& tip : hand.tips)
        EXPECT_TRUE(surface.inside(tip));
    const double litres = 1e-6 * enclosed_volume(hand.surface.vertices, hand.surface.triangles);
    EXPECT_GT(litres, 0.2); // with a piece of forearm; a hand alone is about 0.4 l
    EXPECT_LT(litres, 0.8);
}

TEST(HandModel, leftMirrorsRight)
{
    const HandModel right = make_hand(false), left = make_hand(true);
    for (std::size_t f = 0; f < 5; ++f)
        EXPECT_TRUE(left.tips[f].isApprox(Vec3(-right.tips[f].x(), right.tips[f].y(), right.tips[f].z())));
}

TEST(HandModel, isPlacedByItsFingertips)
{
    const HandModel hand = make_hand(false);
    const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
    const Vec3 shift(10.0, 20.0, -30.0);
    for (const std::size_t count : { 1U, 2U, 3U }) {
        std::vector<Vec3> tips;
        for (std::size_t f = 0; f < count; ++f)
            tips.push_back(turn * hand.tips[f] + shift);
        const HandModel placed = placed_hand(hand, tips);
        for (std::size_t f = 0; f < count; ++f)
            EXPECT_LT((placed.tips[f] - tips[f]).norm(), 1e-9) << count;
        EXPECT_NEAR(enclosed_volume(placed.surface.vertices, placed.surface.triangles),
            enclosed_volume(hand.surface.vertices, hand.surface.triangles), 1e-3); // not turned inside out
    }
}

TEST(HandModel, refusesHandsThatAreNone)
{
    EXPECT_EQ(message_of([] { make_hand(false, 20.0); }), "a hand is 100 to 260 mm long, got 20.000000 []");
    const HandModel hand = make_hand(false);
    const auto placing = [&](const std::vector<Vec3>& tips) { return message_of([&] { placed_hand(hand, tips); }); };
    EXPECT_EQ(placing({}), "a hand is placed by 1 to 5 fingertips, got 0 []");
    EXPECT_EQ(placing(std::vector<Vec3>(6, Vec3::Zero())), "a hand is placed by 1 to 5 fingertips, got 6 []");
    EXPECT_EQ(placing({ Vec3::Zero(), Vec3::UnitX(), Vec3::Zero() }), "lies where fingertip 0 lies [fingertip 2]");
    EXPECT_EQ(placing({ Vec3::Constant(std::nan("")) }), "its place is not finite [fingertip 0]");
}
