#include "planner/case/target_site.h"

#include "mesh/base/error.h"
#include "planner/case/patient.h"
#include "planner/plan/plan.h"
#include "tests/support/block_case.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace retractor::planner {
namespace target_site_test {

    double area_of(const TriMesh& surface)
    {
        double area = 0.0;
        for (const auto& t : surface.triangles) {
            const Vec3 a = surface.vertices.row(t[0]), b = surface.vertices.row(t[1]), c = surface.vertices.row(t[2]);
            area += 0.5 * (b - a).cross(c - a).norm();
        }
        return area;
    }

    TEST(TargetSite, OnASphereIsACap)
    {
        const double radius = 20.0;
        const TriMesh organ = sphere_surface(Vec3(5.0, -3.0, 100.0), radius);
        for (const double reach : { 5.0, 9.0, 15.0 }) {
            const TargetSpec site { .label = "heart",
                .centre = Vec3(5.0, -3.0, 100.0) + radius * Vec3(0.6, 0.0, 0.8),
                .radius_mm = reach,
                .site = "anastomosis site" };
            const TriMesh part = site_surface(organ, site);
            // A cap's area is pi times the square of the chord (Archimedes). Whole triangles make its border ragged.
            const double wanted = std::numbers::pi * reach * reach;
            constexpr double kRagged = 0.1;
            EXPECT_NEAR(area_of(part), wanted, kRagged * wanted) << reach;
            EXPECT_NEAR(
                area_of(part) + area_of(surface_beside_site(organ, site)), area_of(organ), 1e-9 * area_of(organ));
        }
    }

    TEST(TargetSite, AwayFromTheSurfaceIsRefusedWithItsDistance)
    {
        const TargetSpec site { .label = "heart", .centre = Vec3(50.0, 0.0, 0.0), .radius_mm = 8.0, .site = "annulus" };
        try {
            static_cast<void>(site_surface(sphere_surface(Vec3::Zero(), 20.0), site));
            FAIL();
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("the annulus lies 30 mm from the surface of \"heart\""),
                std::string::npos)
                << error.what();
        }
    }

    /// A block whose target is a ball below the incision.
    struct Ball {
        datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
        Vec3 centre = Vec3::Zero();
        double radius = 0.0;

        Ball()
        {
            const Label id = mesh::label_named(phantom.labels.table, "target").id;
            double count = 0.0;
            mesh::visit_voxels(phantom.labels, [&](int i, int j, int k, Label label) {
                if (label != id)
                    return;
                centre += phantom.labels.grid.world(Vec3(i, j, k));
                count += 1.0;
            });
            centre /= count;
            radius = std::cbrt(0.75 / std::numbers::pi * count * phantom.labels.grid.voxel_volume());
        }
    };

    TEST(TargetSite, IsFoundAtAPlaceOfAnOrgan)
    {
        const Ball ball;
        const double voxel = ball.phantom.labels.grid.spacing.maxCoeff();
        const TargetSpec middle = site_at(ball.phantom.labels, ball.centre);
        EXPECT_EQ(middle.label, "target");
        EXPECT_NEAR(middle.radius_mm, std::max(kSiteMm, ball.radius + 3.0), voxel + 1.0) << "reaches the surface";
        EXPECT_TRUE(middle.site.empty());
        const TargetSpec edge = site_at(ball.phantom.labels, ball.centre + Vec3(0.0, 0.0, ball.radius - voxel));
        EXPECT_EQ(edge.label, "target");
        EXPECT_EQ(edge.radius_mm, kSiteMm);
        EXPECT_THROW(static_cast<void>(site_at(ball.phantom.labels, Vec3(1e4, 0.0, 0.0))), InputError);
        EXPECT_NO_THROW(check_site(ball.phantom.labels, middle));
        TargetSpec away = edge;
        away.centre += Vec3(0.0, 0.0, kSiteMm + 2.0 * voxel);
        EXPECT_THROW(check_site(ball.phantom.labels, away), InputError);
    }

    TEST(TargetSite, TheOrganHidesItsOwnBack)
    {
        const Ball ball;
        Patient patient(test_support::block_case("site", ball.phantom));
        Approach approach = test_support::block_approach(*patient.labels(), Eigen::Isometry3d::Identity(), 12.0);
        const auto seen = [&](const Vec3& direction) {
            approach.target = { .label = "target",
                .centre = ball.centre + ball.radius * direction,
                .radius_mm = 0.5 * ball.radius,
                .site = "clamp site" };
            return plan_approach(patient, approach, {}, { .error_bars = false });
        };
        const Vec3 inward = approach.directions.front();
        const PlannedField front = seen(-inward), back = seen(inward);
        ASSERT_EQ(front.status, PlanStatus::done) << front.message;
        EXPECT_EQ(front.metrics.target, "clamp site on target");
        EXPECT_GT(front.metrics.seen_best_eye, 0.1);
        EXPECT_EQ(back.metrics.seen_best_eye, 0.0);
        EXPECT_EQ(back.metrics.best_eye_picture, 0.0);
        const auto& hidden_by = back.metrics.best_eye.hidden_by;
        ASSERT_FALSE(hidden_by.empty());
        EXPECT_EQ(hidden_by.front().name, "target") << "by the ball itself";
    }

} // namespace target_site_test
} // namespace retractor::planner
