#include "planner/measures/sight/surgeon_eye.h"

#include "mesh/base/error.h"
#include "tests/planner/measures/sight/sight_scenes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>

namespace retractor::planner {
namespace surgeon_eye_test {

    using namespace sight_scenes;

    /// Of the seen share: the light's edge crosses the samples' cells, N^-3/4 of 4,000.
    constexpr double kSampling = 0.01;
    constexpr int kSamples = 4000;

    /// Eyes above the disc at the origin, 300 to 500 mm away.
    EyePlaces above(double half_angle_deg, int eyes = 61)
    {
        return { .cone = from_above(kEye, half_angle_deg, eyes), .nearest_mm = 300.0, .farthest_mm = 500.0 };
    }

    /// The opening of a plate's round hole at the origin's zenith.
    OpeningGeometry round_opening(double radius)
    {
        OpeningGeometry opening;
        opening.centre = Vec3(0, 0, kPlate);
        opening.length_mm = opening.width_mm = 2.0 * radius;
        return opening;
    }

    SurgeonEye best_of(const RayScene& scene, const EyePlaces& places)
    {
        return best_eye(scene, places, surface_samples(scene.target(), kSamples));
    }

    TEST(SurgeonEye, TheNearestEyeOnTheAxisSeesMostThroughARoundHole)
    {
        // The disc's share in the light cone of the hole grows as the eye comes near.
        constexpr double kHole = 8.0, kNearest = 300.0;
        const RayScene scene(ring(0.0, kDisc, 0.0), { wall(ring(kHole, 400.0, kPlate)) }, {});
        const SurgeonEye best = best_of(scene, above(20.0));
        EXPECT_NEAR(best.seen_fraction, seen_through_hole(kHole, Vec3(0, 0, kNearest)), kSampling);
        EXPECT_NEAR((best.eye - best.aim).norm(), kNearest, 1.0);
        EXPECT_NEAR(best.picture_share, best.seen_fraction, kSampling); // a flat disc, looked at straight
        EXPECT_NEAR(best.bound_area_mm2, kPi * kDisc * kDisc, 0.01 * kPi * kDisc * kDisc);
        ASSERT_EQ(best.hidden_by.size(), 1U);
        EXPECT_EQ(best.hidden_by[0].name, "wall");
        EXPECT_NEAR(best.hidden_by[0].share, 1.0 - best.seen_fraction, 1e-12);
    }

    TEST(SurgeonEye, FindsTheEyeThatLooksThroughAHoleBesideTheAxis)
    {
        // The hole lies 15 mm beside the axis at 60 mm: the disc's middle is seen at 14 degrees.
        constexpr double kHole = 6.0, kAside = 15.0;
        TriMesh plate = ring(kHole, 400.0, kPlate);
        plate.vertices.col(0).array() += kAside;
        const RayScene scene(ring(0.0, kDisc, 0.0), { wall(plate) }, {});
        const SurgeonEye best = best_of(scene, above(20.0));
        // From 300 mm the whole light of the hole falls onto the disc: a circle of this radius.
        const double light = kHole * 300.0 / (300.0 - kPlate / std::cos(0.24));
        EXPECT_NEAR(best.seen_fraction, light * light / (kDisc * kDisc), 0.1 * light * light / (kDisc * kDisc));
        const SurgeonEye straight = best_of(scene, above(0.0, 1));
        EXPECT_GT(best.seen_fraction, straight.seen_fraction);
        EXPECT_LT(best.aim.head<2>().norm(), kDisc);
    }

    TEST(SurgeonEye, AnEyeAboveTheTableLooksDownAndTheBoundStays)
    {
        // As above: the hole is looked through at 14 degrees from the axis, towards +x.
        constexpr double kHole = 6.0, kAside = 15.0, kDegree = kPi / 180.0;
        TriMesh plate = ring(kHole, 400.0, kPlate);
        plate.vertices.col(0).array() += kAside;
        const RayScene scene(ring(0.0, kDisc, 0.0), { wall(plate) }, {});
        EyePlaces places = above(20.0);
        const SurgeonEye anywhere = best_of(scene, places);
        const auto tilted = [](double deg) { return Vec3(-std::sin(deg * kDegree), 0.0, std::cos(deg * kDegree)); };
        for (const double deg : { 0.0, 74.0, 130.0 }) { // of the direction away from the floor, from the axis
            places.up = tilted(deg);
            const SurgeonEye best = best_of(scene, places);
            EXPECT_EQ(best.bound_area_mm2, anywhere.bound_area_mm2) << deg;
            if (deg == 0.0) {
                EXPECT_EQ(best.seen_fraction, anywhere.seen_fraction) << "all of the cone is high enough";
            } else if (deg == 74.0) { // the way through the hole lies 2 degrees above the horizontal
                EXPECT_LT(best.seen_fraction, 0.7 * anywhere.seen_fraction);
                EXPECT_GE(places.up->dot((best.eye - places.cone.aim).normalized()),
                    std::sin(kLowestSightDeg * kDegree) - 1e-9);
            } else {
                EXPECT_EQ(best.seen_fraction, 0.0) << "the whole cone lies below the table";
            }
        }
        places.up = Vec3(0.0, 0.0, 2.0);
        EXPECT_THROW(static_cast<void>(best_of(scene, places)), InputError);
        places.up = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
        EXPECT_THROW(static_cast<void>(best_of(scene, places)), InputError);
    }

    TEST(SurgeonEye, ThePictureHoldsTheShareOfProjectedArea)
    {
        // A sphere half behind a screen that ends in the plane x = 0, seen from the axis: half of its picture, by
        // symmetry, but for the sight that turns to the half that is seen.
        const RayScene scene(sphere(15.0, 80), { wall(box(Vec3(0, -200, 50), Vec3(200, 200, 51))) }, {});
        EXPECT_NEAR(best_of(scene, above(0.0, 1)).picture_share, 0.5, 2.0 * kSampling);
    }

    TEST(SurgeonEye, ZeroIsZero)
    {
        const RayScene scene(sphere(15.0, 40), { wall(ring(0.0, 400.0, kPlate)) }, {});
        SurgeonEye best = best_of(scene, above(20.0));
        add_two_eyes_and_instruments(best, scene, round_opening(5.0), surface_samples(scene.target(), kSamples));
        EXPECT_EQ(best.seen_fraction, 0.0);
        EXPECT_EQ(best.picture_share, 0.0);
        EXPECT_EQ(best.two_eyes_fraction, 0.0);
        EXPECT_EQ(best.two_instruments_fraction, 0.0);
        EXPECT_GT(best.bound_area_mm2, 0.0);
    }

    TEST(SurgeonEye, WhatIsMetTooObliquelyIsNotSeen)
    {
        // A wall removed leaves all of a disc that is tilted by 50 degrees, and nothing of one tilted by 70.
        const auto seen = [](double tilt_deg) {
            Eigen::Isometry3d turn(Eigen::AngleAxisd(tilt_deg * kPi / 180.0, Vec3::UnitX()));
            const RayScene scene(moved(ring(0.0, kDisc, 0.0), turn), {}, {});
            return best_of(scene, above(0.0, 1));
        };
        EXPECT_EQ(seen(50.0).seen_fraction, 1.0);
        EXPECT_NEAR(seen(50.0).incidence_deg, 50.0, 1.0);
        EXPECT_EQ(seen(75.0).seen_fraction, 0.0);
        EXPECT_EQ(seen(75.0).picture_share, 1.0); // it stands in the picture all the same
        // Of a sphere, what is met at less than 60 degrees is the cap of half angle 60 degrees less the parallax.
        const RayScene ball(sphere(15.0, 120), {}, {});
        const SurgeonEye best
            = best_eye(ball, { .cone = from_above(kEye, 0.0, 1), .nearest_mm = kEye, .farthest_mm = kEye },
                surface_samples(ball.target(), kSamples));
        const double cap = kPi / 3.0 - std::asin(15.0 / kEye * std::sin(kPi / 3.0));
        EXPECT_NEAR(best.bound_area_mm2, 2.0 * kPi * 15.0 * 15.0 * (1.0 - std::cos(cap)), 0.02 * best.bound_area_mm2);
    }

    TEST(SurgeonEye, TwoEyesLoseWhatThePlateHidesFromEither)
    {
        // A slit along x, 12 mm wide and 60 mm above the disc: eyes beside each other along x both look through it, and
        // eyes across it do not. The best turn of the head sees what one eye sees.
        OpeningGeometry slit;
        slit.centre = Vec3(0, 0, kPlate);
        slit.length_mm = 200.0;
        slit.width_mm = 12.0;
        const std::vector<Occluder> halves { wall(box(Vec3(-200, 6, 60), Vec3(200, 200, 61))),
            wall(box(Vec3(-200, -200, 60), Vec3(200, -6, 61))) };
        const RayScene scene(ring(0.0, kDisc, 0.0), halves, {});
        const auto samples = surface_samples(scene.target(), kSamples);
        SurgeonEye best = best_eye(scene, above(0.0, 1), samples);
        add_two_eyes_and_instruments(best, scene, slit, samples);
        EXPECT_GT(best.two_eyes_fraction, 0.97 * best.seen_fraction);
        // Through a round hole of 6 mm two eyes share only a lens of what either sees.
        const RayScene hole(ring(0.0, kDisc, 0.0), { wall(ring(6.0, 400.0, kPlate)) }, {});
        SurgeonEye through = best_eye(hole, above(0.0, 1), samples);
        add_two_eyes_and_instruments(through, hole, round_opening(6.0), samples);
        const double scale = 300.0 / (300.0 - kPlate), shift = 0.5 * kEyesApartMm * (scale - 1.0);
        EXPECT_NEAR(through.two_eyes_fraction, lens(6.0 * scale, 6.0 * scale, 2.0 * shift) / (kPi * kDisc * kDisc),
            1.5 * kSampling);
    }

    TEST(SurgeonEye, TwoShaftsNeedRoomForBoth)
    {
        const auto reached = [](double hole) {
            const RayScene scene(ring(0.0, kDisc, 0.0), { wall(ring(hole, 400.0, kPlate)) }, {});
            const auto samples = surface_samples(scene.target(), 400);
            SurgeonEye best = best_eye(scene, above(20.0, 16), samples);
            add_two_eyes_and_instruments(best, scene, round_opening(hole), samples);
            return best.two_instruments_fraction / best.seen_fraction;
        };
        // Two shafts 15 degrees apart at a tip 60 mm below are 15.8 mm apart in the hole, and each has a radius of 4
        // mm.
        EXPECT_EQ(reached(10.0), 0.0);
        EXPECT_GT(reached(18.0), 0.9);
    }

    TEST(SurgeonEye, LooksAtABentVesselAndNotBesideIt)
    {
        // Two balls 80 mm apart: their middle is empty.
        TriMesh target = sphere(10.0, 24);
        target.vertices.col(0).array() += 40.0;
        TriMesh other = sphere(10.0, 24);
        other.vertices.col(0).array() -= 40.0;
        const auto first = static_cast<VertexId>(target.vertices.rows());
        Points all(target.vertices.rows() + other.vertices.rows(), 3);
        all << target.vertices, other.vertices;
        target.vertices = all;
        for (const auto& t : other.triangles)
            target.triangles.push_back({ t[0] + first, t[1] + first, t[2] + first });
        const RayScene scene(std::move(target), {}, {});
        const Vec3 aim = aim_through(scene, round_opening(20.0), surface_samples(scene.target(), kSamples));
        EXPECT_NEAR(std::min((aim - Vec3(40, 0, 0)).norm(), (aim + Vec3(40, 0, 0)).norm()), 10.0, 0.2);
    }

    TEST(SurgeonEye, IsCancelledAndRefusesBadPlaces)
    {
        const RayScene scene(ring(0.0, kDisc, 0.0), {}, {});
        const auto samples = surface_samples(scene.target(), 100);
        std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_EQ(best_eye(scene, above(20.0), samples, job).status, ExposureStatus::cancelled);
        EyePlaces places = above(20.0);
        places.nearest_mm = 600.0;
        EXPECT_THROW((void)best_eye(scene, places, samples), InputError);
        places.nearest_mm = std::numeric_limits<double>::quiet_NaN();
        EXPECT_THROW((void)best_eye(scene, places, samples), InputError);
    }

} // namespace surgeon_eye_test
} // namespace retractor::planner
