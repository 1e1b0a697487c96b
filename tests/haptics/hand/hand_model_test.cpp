#include "haptics/hand/hand_model.h"

#include "haptics/spheres/surface_locator.h"
#include "tests/support/test_help.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

using namespace retractor;
using namespace retractor::haptics;

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

TEST(HandModel, isLaidOnTissueByItsFingertips)
{
    const HandModel hand = make_hand(false);
    const Vec3 outward = Vec3(0.3, -0.2, 1.0).normalized(), sight(0.0, 1.0, -1.0), up(0.0, 1.0, 1.0);
    for (const Vec3& eye : { sight, outward }) { // also when the camera's up is out of the tissue
        const std::vector<Vec3> tips { Vec3(10.0, 20.0, -30.0), Vec3(30.0, 0.0, -28.0) };
        const HandPlace place = place_hand(hand, outward, eye, eye == outward ? outward : up, tips);
        EXPECT_LT((place.turn.transpose() * place.turn - Mat3::Identity()).norm(), 1e-12);
        EXPECT_NEAR(place.turn.determinant(), 1.0, 1e-12);
        EXPECT_LT((place.turn.col(2) - outward).norm(), 1e-12); // the palm looks into the tissue
        const auto shown = [&](std::size_t finger) -> Vec3 { return place.turn * hand.tips[finger] + place.shift; };
        EXPECT_LT((shown(1) - tips[0]).norm(), 1e-9);
        // The thumb lies in the other's direction, as seen from above.
        const auto flat = [&](const Vec3& v) -> Vec3 { return v - v.dot(outward) * outward; };
        EXPECT_NEAR(flat(shown(0) - tips[0]).normalized().dot(flat(tips[1] - tips[0]).normalized()), 1.0, 1e-12);
    }
}

TEST(HandModel, handsTakeThreeFingersEachAndFingersInOnePlaceOnce)
{
    const std::array<HandModel, 2> hands { make_hand(false), make_hand(true) };
    const Vec3 out = Vec3::UnitZ(), sight(0.0, 0.5, -1.0), up = Vec3::UnitY();
    const auto finger = [&](double x, double y) { return ShownFinger { Vec3(x, y, 3.0), 4.0, out }; };
    const auto shown = [&](const HandPlace& place, std::size_t h, std::size_t tip) -> Vec3 {
        return place.turn * hands[h].tips[tip] + place.shift;
    };
    EXPECT_FALSE(place_hands(hands, {}, sight, up)[0]);
    const std::vector<ShownFinger> four { finger(0.0, 0.0), finger(20.0, -5.0), finger(-15.0, 4.0), finger(90.0, 0.0) };
    const auto both = place_hands(hands, four, sight, up), one = place_hands(hands, { four.data(), 3 }, sight, up);
    ASSERT_TRUE(both[0] && both[1] && one[0]);
    EXPECT_FALSE(one[1]);
    constexpr double kRounding = 1e-9; // mm
    // A finger of the hand is as high as its own radius above what the fingertip of 4 mm lies on.
    for (const std::size_t h : { 0U, 1U }) {
        const Vec3 place = four[h * kFingersPerHand].tip + (hands[h].tip_radius[1] - 4.0) * out;
        EXPECT_LT((shown(*both[h], h, 1) - place).norm(), kRounding);
    }
    // The first finger twice gives no direction: the next one does.
    const std::vector<ShownFinger> twice { four[0], four[0], four[1] };
    const auto with = place_hands(hands, twice, sight, up), without = place_hands(hands, { four.data(), 2 }, sight, up);
    EXPECT_TRUE(with[0]->turn.isApprox(without[0]->turn, 1e-12));
    // Against each other: from the eye.
    std::vector<ShownFinger> pinch { four[0], four[1] };
    pinch[1].outward = -out;
    EXPECT_LT((place_hands(hands, pinch, sight, up)[0]->turn.col(2) + sight.normalized()).norm(), 1e-12);
}

TEST(HandModel, refusesHandsThatAreNone)
{
    EXPECT_EQ(test_support::message_of([] { make_hand(false, 20.0); }), "a hand is 100 to 260 mm long, got 20.000000");
    const HandModel hand = make_hand(false);
    const auto placing = [&](const std::vector<Vec3>& tips) {
        return test_support::message_of([&] { place_hand(hand, Vec3::UnitZ(), -Vec3::UnitZ(), Vec3::UnitY(), tips); });
    };
    EXPECT_EQ(placing({}), "a hand is placed by 1 to 5 fingertips, got 0");
    EXPECT_EQ(placing(std::vector<Vec3>(6, Vec3::Zero())), "a hand is placed by 1 to 5 fingertips, got 6");
    EXPECT_EQ(placing({ Vec3::Constant(std::nan("")) }), "fingertip 0: its place is not finite");
}
