#include "planner/measures/sight/exposure.h"

#include "mesh/base/error.h"
#include "tests/planner/measures/sight/sight_scenes.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numbers>

namespace retractor::planner {
namespace exposure_test {

    using namespace sight_scenes;

    /// Stratified samples, 4,000 of them, miss an area by about N^-3/4 = 0.2 % where the edge of the light crosses.
    constexpr double kSampling = 0.004;

    TEST(Exposure, HoleOverDiscFromTheAxis)
    {
        const TriMesh disc = ring(0.0, kDisc, 0.0);
        for (const double hole : { 2.0, 5.0, 10.0, 15.0 }) {
            const Exposure seen
                = measure_exposure(disc, { wall(ring(hole, 200.0, kPlate)) }, from_above(kEye, 15.0, 1), 40000);
            const double exact = seen_through_hole(hole, Vec3(0, 0, kEye));
            EXPECT_NEAR(seen.central_eye_fraction, exact, 0.01 * exact) << hole;
            EXPECT_EQ(seen.visible_fraction, seen.central_eye_fraction);
            EXPECT_EQ(seen.visible_fraction_unobstructed, 1.0);
            EXPECT_NEAR(seen.target_area_mm2, kPi * kDisc * kDisc, 1e-4 * kPi * kDisc * kDisc);
        }
    }

    TEST(Exposure, ConeMeanMatchesQuadrature)
    {
        constexpr double kHole = 10.0, kHalf = 20.0;
        const Exposure seen = measure_exposure(
            ring(0.0, kDisc, 0.0), { wall(ring(kHole, 400.0, kPlate)) }, from_above(kEye, kHalf, 200), 2000);
        // Mean over the cap by its height, which is proportional to area; the scene is round.
        double exact = 0.0;
        constexpr int kSteps = 20000;
        for (int i = 0; i < kSteps; ++i) {
            const double c = 1.0 - (1.0 - std::cos(kHalf * kPi / 180.0)) * (i + 0.5) / kSteps;
            exact += seen_through_hole(kHole, kEye * Vec3(std::sqrt(1.0 - c * c), 0.0, c)) / kSteps;
        }
        EXPECT_NEAR(seen.mean_visible_fraction, exact, 0.01 * exact);
        for (const EyeView& view : seen.eyes)
            EXPECT_NEAR(view.visible_fraction, seen_through_hole(kHole, view.eye), 2.0 * kSampling);
        EXPECT_GE(seen.visible_fraction, seen.mean_visible_fraction); // more from the cone than from any one place
    }

    TEST(Exposure, RisesWithTheHole)
    {
        double last = -1.0, last_mean = -1.0;
        for (const double hole : { 0.0, 1.0, 2.0, 4.0, 8.0, 12.0, 16.0, 40.0 }) {
            const Exposure seen = measure_exposure(
                ring(0.0, kDisc, 0.0), { wall(ring(hole, 400.0, kPlate)) }, from_above(kEye, 15.0, 16), 1000);
            EXPECT_GE(seen.visible_fraction, last);
            EXPECT_GE(seen.mean_visible_fraction, last_mean);
            EXPECT_LE(seen.visible_fraction, seen.visible_fraction_unobstructed);
            last = seen.visible_fraction;
            last_mean = seen.mean_visible_fraction;
            if (hole == 0.0) {
                EXPECT_EQ(seen.visible_fraction, 0.0);
            }
        }
        EXPECT_EQ(last, 1.0);
    }

    TEST(Exposure, ClosedSlitHidesEverything)
    {
        // Two halves of a wall, 20 mm thick, whose lips coincide in the plane x = 0.
        const std::vector<Occluder> halves { wall(box(Vec3(-200, -200, 50), Vec3(0, 200, 70))),
            wall(box(Vec3(0, -200, 50), Vec3(200, 200, 70))) };
        const Exposure seen = measure_exposure(sphere(15.0, 40), halves, from_above(kEye, 20.0, 32), 2000);
        EXPECT_EQ(seen.visible_fraction, 0.0);
        EXPECT_GT(seen.visible_fraction_unobstructed, 0.4);
    }

    TEST(Exposure, UnobstructedSphereShowsItsCap)
    {
        constexpr double kRadius = 15.0;
        const Exposure seen = measure_exposure(sphere(kRadius, 120),
            { wall(box(Vec3(-200, -200, 50), Vec3(200, 200, 70))) }, from_above(kEye, 0.0, 1), 4000);
        // The cap from which the eye is above the tangent plane: (1 - R/D) / 2 of the sphere.
        EXPECT_NEAR(seen.visible_fraction_unobstructed, 0.5 * (1.0 - kRadius / kEye), kSampling);
        EXPECT_EQ(seen.visible_fraction, 0.0);

        // From at least one eye of a cone of half angle a: the cap opens by a (with enough eyes on the cone's rim).
        const Exposure wide = measure_exposure(sphere(kRadius, 120), {}, from_above(kEye, 30.0, 400), 4000);
        const double edge = std::acos(kRadius / kEye) + 30.0 * kPi / 180.0;
        EXPECT_NEAR(wide.visible_fraction_unobstructed, 0.5 * (1.0 - std::cos(edge)), 0.015);
        EXPECT_EQ(wide.visible_fraction, wide.visible_fraction_unobstructed);
    }

    TEST(Exposure, BarIsNamedWithItsShare)
    {
        // A bar of bone, 10 mm wide, across the disc at half the eye's height: it covers a strip twice as wide. It lies
        // inside a plate of muscle with a hole, so that the rib shows only where the hole is.
        constexpr double kHalfStrip = 10.0;
        Occluder bar;
        bar.name = "wall";
        bar.surface = box(Vec3(-100, -5, 199.9), Vec3(100, 5, 200.0));
        bar.surface.labels.assign(bar.surface.triangles.size(), 7);
        bar.labels = { { 7, "rib_left_5", "bone", mesh::Role::wall }, { 8, "muscle", "muscle", mesh::Role::wall } };
        const Exposure seen = measure_exposure(ring(0.0, kDisc, 0.0), { bar }, from_above(kEye, 0.0, 1), 4000);
        const double a = std::asin(kHalfStrip / kDisc);
        const double strip = (2.0 * a + std::sin(2.0 * a)) / kPi; // share of a disc within |y| < kHalfStrip
        ASSERT_EQ(seen.bone_in_sight.size(), 1U);
        EXPECT_EQ(seen.bone_in_sight[0].name, "rib_left_5");
        EXPECT_NEAR(seen.bone_in_sight[0].share, strip, 0.01 * strip);
        ASSERT_EQ(seen.blocked_by.size(), 1U);
        EXPECT_EQ(seen.blocked_by[0].name, "rib_left_5");
        EXPECT_NEAR(seen.visible_fraction, 1.0 - strip, 0.01 * strip);
        EXPECT_NEAR(seen.visible_fraction + seen.blocked_by[0].share, 1.0, 1e-12); // no sample hides another

        // Muscle above it meets the rays first, and the rib is still named.
        Occluder muscle = wall(ring(0.0, 100.0, 210.0));
        muscle.surface.labels.assign(muscle.surface.triangles.size(), 8);
        muscle.labels = bar.labels;
        const Exposure hidden
            = measure_exposure(ring(0.0, kDisc, 0.0), { bar, muscle }, from_above(kEye, 0.0, 1), 4000);
        ASSERT_EQ(hidden.blocked_by.size(), 1U);
        EXPECT_EQ(hidden.blocked_by[0].name, "muscle");
        EXPECT_EQ(hidden.blocked_by[0].share, 1.0);
        ASSERT_EQ(hidden.bone_in_sight.size(), 1U);
        EXPECT_EQ(hidden.bone_in_sight[0].share, seen.bone_in_sight[0].share);
    }

    TEST(Exposure, OrgansStayWhenTheWallIsRemoved)
    {
        Occluder lung;
        lung.name = "lung_left";
        lung.surface = box(Vec3(0, -50, 20), Vec3(50, 50, 30)); // covers x > 0 of the disc
        lung.material = "lung";
        lung.wall = false;
        const Exposure seen = measure_exposure(
            ring(0.0, kDisc, 0.0), { lung, wall(ring(0.0, 200.0, kPlate)) }, from_above(kEye, 0.0, 1), 4000);
        EXPECT_NEAR(seen.visible_fraction_unobstructed, 0.5, kSampling);
        EXPECT_EQ(seen.visible_fraction, 0.0);
        ASSERT_EQ(seen.blocked_by.size(), 1U);
        EXPECT_EQ(seen.blocked_by[0].name, "wall"); // first met, though the lung blocks half of it again
        EXPECT_TRUE(seen.bone_in_sight.empty());
    }

    TEST(Exposure, TouchingOrganDoesNotSwallowTheTarget)
    {
        const auto share_seen = [](double overlap) {
            Occluder heart;
            heart.name = "heart";
            heart.surface = box(Vec3(-50, -50, -40), Vec3(50, 50, overlap));
            heart.wall = false;
            return measure_exposure(ring(0.0, kDisc, 0.0), { heart }, from_above(kEye, 0.0, 1), 200).visible_fraction;
        };
        EXPECT_EQ(share_seen(0.4), 1.0); // less than kContactMm
        EXPECT_EQ(share_seen(0.6), 0.0);
    }

    TEST(Exposure, SamplesShowWhatIsSeenForPictures)
    {
        constexpr double kHole = 10.0;
        const Exposure seen = measure_exposure(
            ring(0.0, kDisc, 0.0), { wall(ring(kHole, 200.0, kPlate)) }, from_above(kEye, 0.0, 1), 500);
        ASSERT_EQ(seen.sample_points.size(), 500U);
        ASSERT_EQ(seen.sample_seen.size(), 500U);
        const double edge = kHole * kEye / (kEye - kPlate);
        for (std::size_t s = 0; s < 500; ++s) {
            const double r = seen.sample_points[s].position.norm();
            if (std::abs(r - edge) > 0.01) { // the hole is a polygon of 360 sides
                EXPECT_EQ(seen.sample_seen[s], r < edge ? 1.0F : 0.0F) << r;
            }
        }
    }

    TEST(Exposure, SameUnderRigidMotion)
    {
        /// Single precision moves the light's edge by about 1e-4 mm: less than one sample in a thousand changes sides.
        constexpr double kEquivariance = 1e-3;
        const TriMesh target = sphere(15.0, 30);
        const std::vector<Occluder> still { wall(ring(12.0, 300.0, kPlate)) };
        const ViewCone cone = from_above(kEye, 20.0, 16);
        const Exposure a = measure_exposure(target, still, cone, 2000);
        Eigen::Isometry3d pose(Eigen::AngleAxisd(1.1, Vec3(3, -1, 2).normalized()));
        pose.pretranslate(Vec3(500, -300, 1200));
        ViewCone turned = cone;
        turned.aim = pose * cone.aim;
        turned.axis = pose.linear() * cone.axis;
        turned.up = pose.linear() * cone.up;
        const Exposure b = measure_exposure(moved(target, pose), { wall(moved(still[0].surface, pose)) }, turned, 2000);
        EXPECT_GT(a.visible_fraction, 0.1);
        EXPECT_NEAR(a.visible_fraction, b.visible_fraction, kEquivariance);
        EXPECT_NEAR(a.mean_visible_fraction, b.mean_visible_fraction, kEquivariance);
        EXPECT_NEAR(a.visible_fraction_unobstructed, b.visible_fraction_unobstructed, kEquivariance);
        for (std::size_t e = 0; e < a.eyes.size(); ++e)
            EXPECT_NEAR((pose * a.eyes[e].eye - b.eyes[e].eye).norm(), 0.0, 1e-9);
    }

    TEST(Exposure, ConvergesWithSamples)
    {
        const double exact = seen_through_hole(10.0, Vec3(0, 0, kEye));
        const TriMesh disc = ring(0.0, kDisc, 0.0);
        const std::vector<Occluder> plate { wall(ring(10.0, 200.0, kPlate)) };
        // Mean error over a run of neighbouring counts, so that one lucky count does not decide.
        const auto error = [&](int count) {
            double sum = 0.0;
            for (int i = 0; i < 8; ++i)
                sum += std::abs(measure_exposure(disc, plate, from_above(kEye, 0.0, 1), count + 7 * i).visible_fraction
                           - exact)
                    / 8.0;
            return sum;
        };
        const double coarse = error(100), fine = error(6400);
        EXPECT_LT(fine, coarse / 8.0); // plain random samples would gain a factor of 8
        EXPECT_LT(fine, 0.003);
    }

    TEST(Exposure, IsRecordedAndCancelled)
    {
        Ledger ledger;
        Job job;
        job.ledger = &ledger;
        const TriMesh disc = ring(0.0, kDisc, 0.0);
        const std::vector<Occluder> plate { wall(ring(10.0, 200.0, kPlate)) };
        EXPECT_EQ(measure_exposure(disc, plate, from_above(kEye, 15.0, 8), 500, job).status, ExposureStatus::done);
        ASSERT_EQ(ledger.parts().size(), 1U);
        EXPECT_EQ(ledger.parts()[0].name, "ray tracer");
        EXPECT_GT(ledger.parts()[0].bytes, 0U);

        std::atomic<bool> cancel { true };
        job.cancel = &cancel;
        EXPECT_EQ(measure_exposure(disc, plate, from_above(kEye, 15.0, 8), 500, job).status, ExposureStatus::cancelled);
    }

    TEST(EyePositions, FillTheCapEvenly)
    {
        const ViewCone cone = from_above(300.0, 25.0, 500);
        const auto eyes = eye_positions(cone);
        ASSERT_EQ(eyes.size(), 500U);
        EXPECT_NEAR((eyes[0] - Vec3(0, 0, 300)).norm(), 0.0, 1e-12);
        const double cap = std::cos(25.0 * kPi / 180.0);
        Vec3 mean = Vec3::Zero();
        for (const Vec3& eye : eyes) {
            EXPECT_NEAR(eye.norm(), 300.0, 1e-9);
            EXPECT_GE(eye.z(), 300.0 * cap);
            mean += eye / 500.0;
        }
        EXPECT_NEAR(mean.z(), 300.0 * 0.5 * (1.0 + cap), 0.1); // centroid of a cap
        EXPECT_NEAR(mean.head<2>().norm(), 0.0, 0.5);
    }

    template <class Call> std::string message_of(Call&& call)
    {
        try {
            call();
        } catch (const InputError& error) {
            return error.what();
        }
        return "nothing was thrown";
    }

    TEST(Exposure, RefusesBadInput)
    {
        const TriMesh disc = ring(0.0, kDisc, 0.0);
        const auto with_cone = [&](auto&& change) {
            ViewCone cone = from_above(kEye, 15.0, 4);
            change(cone);
            return message_of([&] { (void)measure_exposure(disc, {}, cone, 100); });
        };
        EXPECT_EQ(message_of([] { (void)measure_exposure({}, {}, from_above(kEye, 15.0, 4), 100); }),
            "the target's surface is empty or has no area");
        EXPECT_EQ(
            with_cone([](ViewCone& c) { c.axis[1] = std::nan(""); }), "the view cone has a value that is not finite");
        EXPECT_EQ(with_cone([](ViewCone& c) { c.axis.setZero(); }), "the view cone's axis has no length");
        EXPECT_EQ(
            with_cone([](ViewCone& c) { c.up = c.axis; }), "the view cone's up vector must not lie along its axis");
        EXPECT_EQ(with_cone([](ViewCone& c) { c.eyes = 0; }), "a view cone needs at least one eye, not 0");
        EXPECT_NE(with_cone([](ViewCone& c) { c.half_angle_deg = 90.0; }), "nothing was thrown");
        EXPECT_NE(with_cone([](ViewCone& c) { c.eye_distance_mm = std::nan(""); }), "nothing was thrown");
        EXPECT_EQ(message_of([&] { (void)measure_exposure(disc, {}, from_above(kEye, 15.0, 4), 0); }),
            "at least one sample is needed, not 0");
        Occluder broken = wall(ring(5.0, 50.0, 10.0));
        broken.surface.vertices(3, 0) = std::nan("");
        EXPECT_EQ(message_of([&] { (void)measure_exposure(disc, { broken }, from_above(kEye, 15.0, 4), 100); }),
            "the surface 'wall' has a vertex that is not finite");
        broken = wall(ring(5.0, 50.0, 10.0));
        broken.surface.triangles[2][1] = 100000;
        EXPECT_EQ(message_of([&] { (void)measure_exposure(disc, { broken }, from_above(kEye, 15.0, 4), 100); }),
            "the surface 'wall' uses vertex 100000 of 720");
    }

    TEST(Exposure, RefusesACentralEyeInsideTissue)
    {
        const TriMesh disc = ring(0.0, kDisc, 0.0);
        const std::vector<Occluder> around { wall(box(Vec3(-200, -200, 300), Vec3(200, 200, 500))) };
        EXPECT_EQ(message_of([&] { (void)measure_exposure(disc, around, from_above(kEye, 15.0, 4), 100); }),
            "the central eye is inside 'wall': move it away from the aim");
    }

} // namespace exposure_test
} // namespace retractor::planner
