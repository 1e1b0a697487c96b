#include "planner/measures/sight/instruments.h"

#include "planner/measures/sight/surgeon_eye.h"
#include "tests/planner/measures/sight/sight_scenes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace retractor::planner {
namespace instruments_test {

    using namespace sight_scenes;

    constexpr int kSamples = 2000;

    OpeningGeometry round_opening(double radius, double height)
    {
        OpeningGeometry opening;
        opening.centre = Vec3(0, 0, height);
        opening.length_mm = opening.width_mm = 2.0 * radius;
        return opening;
    }

    RayScene disc_under_hole(double hole, double height)
    {
        return RayScene(ring(0.0, kDisc, 0.0), { wall(ring(hole, 400.0, height)) }, {});
    }

    FingerReach finger(double hole, double height)
    {
        const RayScene scene = disc_under_hole(hole, height);
        return finger_reach(scene, round_opening(hole, height), surface_samples(scene.target(), kSamples));
    }

    TEST(FingerReach, AWideHoleCloseAboveLetsTheFingerTouchAll)
    {
        EXPECT_EQ(finger(30.0, 60.0).touched.size(), static_cast<std::size_t>(kSamples));
        EXPECT_FALSE(finger(30.0, 60.0).lacks_mm);
    }

    TEST(FingerReach, AHoleThinnerThanTheFingerLetsNothingThrough)
    {
        const FingerReach none = finger(7.0, 60.0); // the finger's radius is 8
        EXPECT_EQ(none.touched.size(), 0U);
        EXPECT_FALSE(none.lacks_mm) << "no finger fits, however long";
    }

    TEST(FingerReach, TellsWhatADeepTargetLacks)
    {
        const FingerReach deep = finger(30.0, 120.0);
        EXPECT_EQ(deep.touched.size(), 0U);
        ASSERT_TRUE(deep.lacks_mm);
        EXPECT_NEAR(*deep.lacks_mm, 120.0 - kFingerReachMm, 0.5); // straight down
    }

    TEST(FingerReach, TouchesTheSphereOfItsLength)
    {
        // From a small hole at a height h a finger of length L touches a circle of radius sqrt(L^2 - h^2) on the disc:
        // its middle passes the hole's middle nearly.
        constexpr double kHole = 9.5, kHeight = 79.0;
        const double radius = std::sqrt(kFingerReachMm * kFingerReachMm - kHeight * kHeight);
        const double share = radius * radius / (kDisc * kDisc);
        const std::vector<std::size_t> samples = finger(kHole, kHeight).touched;
        const RayScene scene = disc_under_hole(kHole, kHeight);
        const std::vector<SurfaceSample> places = surface_samples(scene.target(), kSamples);
        for (const std::size_t sample : samples)
            EXPECT_LT(places.at(sample).position.head<2>().norm(), 1.1 * radius);
        const double touched = static_cast<double>(samples.size()) / kSamples;
        EXPECT_NEAR(touched, share, 0.15 * share) << "the hole is wider than the finger by 1.5 mm";
    }

    TEST(FingerReach, MoreThanAnEyeCouldSeeCountsAsAll)
    {
        SurgeonEye eye { .aim = Vec3::Zero(), .bound_area_mm2 = kPi * kDisc * kDisc };
        const RayScene scene = disc_under_hole(30.0, 60.0);
        add_reach(eye, scene, round_opening(30.0, 60.0), surface_samples(scene.target(), kSamples));
        EXPECT_NEAR(eye.finger_fraction, 1.0, 1e-3); // the disc is a polygon
        EXPECT_EQ(eye.finger_touches.size(), static_cast<std::size_t>(kSamples));
        eye.bound_area_mm2 *= 0.5; // an eye sees one half at most: touching all is all the same 1
        add_reach(eye, scene, round_opening(30.0, 60.0), surface_samples(scene.target(), kSamples));
        EXPECT_EQ(eye.finger_fraction, 1.0);
    }

    TEST(SurgicalFreedom, OfARoundHoleIsTheCapWhereTheShaftFits)
    {
        for (const double hole : { 12.0, 20.0, 35.0 }) {
            const double height = 70.0;
            // A shaft of radius r through the rim of a hole: the axis passes at R - r / cos(angle) from its middle.
            double angle = std::atan(hole / height);
            for (int i = 0; i < 50; ++i)
                angle = std::atan((hole - 0.5 * kShaftMm / std::cos(angle)) / height);
            const double cap = 2.0 * kPi * (1.0 - std::cos(angle)) * kShaftLengthMm * kShaftLengthMm;
            EXPECT_NEAR(surgical_freedom_mm2(disc_under_hole(hole, height), round_opening(hole, height), Vec3::Zero()),
                cap, 0.06 * cap)
                << hole; // six rays stand for the round shaft
        }
    }

    TEST(SurgicalFreedom, IsZeroWhereNoShaftFits)
    {
        EXPECT_EQ(surgical_freedom_mm2(disc_under_hole(3.5, 70.0), round_opening(3.5, 70.0), Vec3::Zero()), 0.0);
    }

    TEST(SurgicalFreedom, ABarTakesItsShadow)
    {
        const RayScene open = disc_under_hole(30.0, 70.0);
        const RayScene barred(ring(0.0, kDisc, 0.0),
            { wall(ring(30.0, 400.0, 70.0)), wall(box(Vec3(-200, 0, 40), Vec3(200, 200, 41))) }, {});
        const double all = surgical_freedom_mm2(open, round_opening(30.0, 70.0), Vec3::Zero()),
                     half = surgical_freedom_mm2(barred, round_opening(30.0, 70.0), Vec3::Zero());
        EXPECT_LT(half, 0.5 * all) << "the shaft keeps its radius from the bar";
        EXPECT_GT(half, 0.3 * all);
    }

} // namespace instruments_test
} // namespace retractor::planner
