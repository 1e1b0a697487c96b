#include "planner/measures/sight/annulus.h"

#include "tests/planner/measures/sight/sight_scenes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace retractor::planner {
namespace annulus_test {

    using namespace sight_scenes;

    /// A band of a tube about the z axis.
    TriMesh band(double radius, double height)
    {
        TriMesh mesh;
        mesh.vertices.resize(2 * kSegments, 3);
        for (int s = 0; s < kSegments; ++s) {
            const double a = 2.0 * kPi * s / kSegments;
            mesh.vertices.row(2 * s) << radius * std::cos(a), radius * std::sin(a), -0.5 * height;
            mesh.vertices.row(2 * s + 1) << radius * std::cos(a), radius * std::sin(a), 0.5 * height;
        }
        for (int s = 0; s < kSegments; ++s) {
            const int n = (s + 1) % kSegments;
            add_quad(mesh, 2 * s, 2 * s + 1, 2 * n + 1, 2 * n);
        }
        return mesh;
    }

    const TargetSpec kTarget { .label = "aorta", .centre = Vec3::Zero(), .radius_mm = 15.0, .site = "annulus" };

    TEST(Annulus, ARingTellsItsPlaneInAnyPose)
    {
        for (const double turn : { 0.0, 0.7, 2.0 }) {
            const Eigen::Isometry3d pose
                = Eigen::Translation3d(5.0, -20.0, 100.0) * Eigen::AngleAxisd(turn, Vec3(1.0, 0.4, -0.3).normalized());
            const double tilt = 30.0 * kPi / 180.0;
            const Vec3 opening = pose * Vec3(100.0 * std::sin(tilt), 0.0, 100.0 * std::cos(tilt));
            const AnnulusAccess access
                = annulus_access(kTarget, moved(band(12.0, 10.0), pose), opening, pose * Vec3(0.0, 0.0, 400.0));
            ASSERT_EQ(access.message, "");
            EXPECT_FALSE(access.given);
            EXPECT_LT((access.centre - pose * Vec3::Zero()).norm(), 1e-9);
            EXPECT_LT((access.normal - pose.linear() * Vec3::UnitZ()).norm(), 1e-9);
            EXPECT_NEAR(access.opening_off_axis_deg, 30.0, 1e-6);
            EXPECT_NEAR(access.sight_off_axis_deg, 0.0, 1e-5);
            EXPECT_NEAR(access.distance_mm, 100.0, 1e-9);
            EXPECT_NEAR(access.diameter_mm, 24.0, 0.01); // chords
        }
    }

    TEST(Annulus, TheNormalPointsTowardsTheOpeningFromEitherSide)
    {
        for (const double side : { 1.0, -1.0 }) {
            const Vec3 opening(0.0, 0.0, side * 80.0);
            EXPECT_NEAR(annulus_access(kTarget, band(12.0, 8.0), opening, 4.0 * opening).normal.z(), side, 1e-12);
        }
    }

    TEST(Annulus, ALongTubeHasNoPlaneUnlessItIsGiven)
    {
        // Second moments: R^2/2 across and h^2/12 along are equal at h = 2.45 R.
        TargetSpec target = kTarget;
        const TriMesh tube = band(12.0, 28.0);
        const AnnulusAccess unclear = annulus_access(target, tube, Vec3(0, 0, 80), Vec3(0, 0, 400));
        EXPECT_NE(unclear.message.find("give a normal"), std::string::npos);
        target.normal = Vec3(0.0, 3.0, 3.0);
        const AnnulusAccess given = annulus_access(target, tube, Vec3(0, 0, 80), Vec3(0, 0, 400));
        EXPECT_EQ(given.message, "");
        EXPECT_TRUE(given.given);
        EXPECT_NEAR(given.opening_off_axis_deg, 45.0, 1e-9);
    }

    TEST(Annulus, APatchOfTheWallIsNoRing)
    {
        // A third of the band, and a flat piece: thin across the wall, which is not the valve's axis.
        TriMesh third = band(12.0, 10.0);
        third.triangles.resize(third.triangles.size() / 3);
        EXPECT_NE(annulus_access(kTarget, third, Vec3(0, 0, 80), Vec3(0, 0, 400)).message, "");
        EXPECT_NE(annulus_access(kTarget, ring(0.0, 8.0, 0.0), Vec3(0, 0, 80), Vec3(0, 0, 400)).message, "");
    }

    TEST(Annulus, OnlyASiteIsAnAnnulus)
    {
        EXPECT_TRUE(is_annulus(kTarget));
        TargetSpec other = kTarget;
        other.site = "clamp site";
        EXPECT_FALSE(is_annulus(other));
        other.normal = Vec3::UnitX();
        EXPECT_TRUE(is_annulus(other));
        EXPECT_FALSE(is_annulus({ .label = "annulus" }));
    }

} // namespace annulus_test
} // namespace retractor::planner
