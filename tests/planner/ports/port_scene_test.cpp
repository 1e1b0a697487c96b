#include "planner/ports/port_scene.h"

#include "mesh/base/error.h"
#include "tests/planner/measures/sight/sight_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace retractor::planner {
namespace port_scene_test {

    using namespace sight_scenes;

    constexpr int kSamples = 2000;
    const Job kJob {};

    double degrees(const Vec3& a, const Vec3& b) { return 180.0 / kPi * std::acos(std::clamp(a.dot(b), -1.0, 1.0)); }

    TEST(PortScene, TheViewLeavesTheShaftAtTheOpticsAngle)
    {
        const PortScene scene(sphere(15.0, 40), {}, {}, kSamples, kJob);
        const Vec3 skin(0.0, 0.0, 160.0);
        for (const double tilt : { 0.0, 30.0, 45.0 }) {
            const ScopeView view = scene.best_scope(skin, 20.0, { .tilt_deg = tilt }, {});
            ASSERT_GT(view.seen, 0U) << tilt;
            EXPECT_NEAR(degrees((view.tip - skin).normalized(), view.view), tilt, 1e-4);
            EXPECT_NEAR(view.insertion_mm, (view.tip - skin).norm(), 1e-9);
            EXPECT_GE(view.insertion_mm, 20.0 + 15.0) << "the lens has left the wall";
            EXPECT_LE(view.seen, view.bound);
            EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(view.sees, true)), view.seen);
        }
    }

    TEST(PortScene, AFreeSphereIsSeenAsFarAsTheViewMeetsItSteeply)
    {
        // From a distance d a sphere of radius R shows the cap of half angle 60 degrees less the parallax.
        constexpr double kRadius = 15.0;
        const PortScene scene(sphere(kRadius, 80), {}, {}, 4000, kJob);
        const ScopeView view = scene.best_scope(Vec3(0, 0, 200.0), 20.0, { .tilt_deg = 0.0 }, {});
        const double cap = kPi / 3.0 - std::asin(kRadius / view.to_target_mm * std::sin(kPi / 3.0));
        EXPECT_NEAR(static_cast<double>(view.seen) / 4000.0, 0.5 * (1.0 - std::cos(cap)), 0.01);
        EXPECT_EQ(view.seen, view.bound) << "nothing is in the way";
    }

    TEST(PortScene, ANarrowConeSeesOnlyItsOwnCircle)
    {
        // A disc of 20 mm seen straight from 130 mm at most: the cone of 10 degrees lights a circle.
        const PortScene scene(ring(0.0, kDisc, 0.0), {}, {}, 4000, kJob);
        const ScopeView view = scene.best_scope(Vec3(0, 0, 250.0), 20.0, { .tilt_deg = 0.0, .field_deg = 10.0 }, {});
        const double light = view.to_target_mm * std::tan(5.0 * kPi / 180.0);
        EXPECT_NEAR(static_cast<double>(view.seen) / 4000.0, light * light / (kDisc * kDisc),
            0.1 * light * light / (kDisc * kDisc));
    }

    TEST(PortScene, NoScopeGoesThroughBoneAndNoViewThroughAnOrgan)
    {
        const auto plate = [] { return wall(ring(0.0, 400.0, 140.0)); };
        const PortScene bone(sphere(15.0, 40), {}, { plate() }, kSamples, kJob);
        EXPECT_EQ(bone.best_scope(Vec3(0, 0, 160.0), 5.0, {}, {}).seen, 0U);
        Occluder organ = wall(ring(0.0, 400.0, 30.0));
        organ.wall = false;
        const PortScene hidden(sphere(15.0, 40), { organ }, {}, kSamples, kJob);
        const ScopeView view = hidden.best_scope(Vec3(0, 0, 160.0), 20.0, {}, {});
        EXPECT_EQ(view.seen, 0U);
        EXPECT_GT(view.bound, 0U) << "alone it would be seen";
    }

    TEST(PortScene, AShaftReachesWhatTheHoleLetsIt)
    {
        // A shaft pivots in the port; a bone with a round hole half way lets it onto a circle.
        constexpr double kHole = 8.0, kHeight = 60.0, kPort = 120.0;
        const PortScene scene(ring(0.0, kDisc, 0.0), {}, { wall(ring(kHole, 400.0, kHeight)) }, 4000, kJob);
        const PortSizes sizes { .shaft_mm = 5.0 };
        const std::vector<bool> reached = scene.reached(Vec3(0, 0, kPort), sizes);
        const double circle = (kHole - 0.5 * sizes.shaft_mm) * kPort / (kPort - kHeight);
        const double share = circle * circle / (kDisc * kDisc);
        EXPECT_NEAR(static_cast<double>(std::ranges::count(reached, true)) / 4000.0, share, 0.1 * share);
        // Too short an instrument reaches nothing.
        const std::vector<bool> none = scene.reached(Vec3(0, 0, kPort), { .longest_mm = 100.0 });
        EXPECT_EQ(std::ranges::count(none, true), 0);
    }

    TEST(PortScene, DistanceOfPiecesIsThatOfTheirNearestPoints)
    {
        std::mt19937 random(7);
        std::uniform_real_distribution<double> number(-1.0, 1.0);
        const auto point = [&] { return Vec3(number(random), number(random), number(random)); };
        for (int n = 0; n < 200; ++n) {
            const std::pair<Vec3, Vec3> a { point(), point() }, b { point(), point() };
            double least = std::numeric_limits<double>::infinity();
            constexpr int kSteps = 120;
            for (int i = 0; i <= kSteps; ++i)
                for (int j = 0; j <= kSteps; ++j)
                    least = std::min(least,
                        (a.first + (a.second - a.first) * i / kSteps - b.first - (b.second - b.first) * j / kSteps)
                            .norm());
            EXPECT_LE(distance_of_pieces(a, b), least + 1e-12);
            EXPECT_NEAR(distance_of_pieces(a, b), least, 0.02); // a step of the grid
            EXPECT_NEAR(distance_of_pieces(a, b), distance_of_pieces(b, a), 1e-12);
        }
    }

    TEST(PortScene, BadOpticsAreRefused)
    {
        EXPECT_THROW(check_optics({ .tilt_deg = 90.0 }), InputError);
        EXPECT_THROW(check_optics({ .tilt_deg = std::numeric_limits<double>::quiet_NaN() }), InputError);
        EXPECT_THROW(check_optics({ .field_deg = 0.0 }), InputError);
    }

} // namespace port_scene_test
} // namespace retractor::planner
