#include "ui/plan_scene/planned_cut.h"

#include "tests/support/block_case.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace retractor::ui {
namespace planned_cut_test {

    class PlannedCut : public testing::Test {
    protected:
        planner::Patient patient_ { test_support::block_case(
            "cut", datasets::make_block_phantom(test_support::small_block())) };
        planner::Approach approach_
            = test_support::block_approach(*patient_.labels(), Eigen::Isometry3d::Identity(), 16.0);
    };

    TEST_F(PlannedCut, IsTheBladesWayFromTheIncisionToItsDepth)
    {
        const SurfaceItem cut = planned_cut(patient_, approach_);
        EXPECT_TRUE(cut.on_top) << "bone does not hide it";
        const auto points = static_cast<Eigen::Index>(approach_.incision.size());
        ASSERT_EQ(cut.mesh->vertices.rows(), 2 * points);
        for (Eigen::Index n = 0; n < points; ++n) {
            const Vec3 skin = cut.mesh->vertices.row(2 * n), deep = cut.mesh->vertices.row(2 * n + 1);
            EXPECT_EQ(skin, approach_.incision[static_cast<std::size_t>(n)]);
            EXPECT_NEAR((deep - skin).norm(), approach_.depth_mm, 1e-9);
            EXPECT_GT((deep - skin).dot(approach_.directions[static_cast<std::size_t>(n)]), 0.0);
        }
        EXPECT_EQ(cut.mesh->triangles.size(), 4U * static_cast<std::size_t>(points - 1)) << "both sides";
    }

    TEST_F(PlannedCut, IsSeenFromTheSideTowardsTheFeetOrTheLeft)
    {
        const Scene scene = planned_cut_scene(patient_, approach_, {});
        const Vec3 along = (approach_.incision.back() - approach_.incision.front()).normalized();
        const Vec3 sight = (scene.camera.aim - scene.camera.eye).normalized();
        const Vec3 across = along.cross(approach_.directions.front()).normalized();
        EXPECT_GT(std::abs(sight.dot(across)), 0.6) << "seen along the blade it would be a line";
        // This incision runs along z: the eye goes to the patient's left.
        EXPECT_GT(scene.camera.eye.x() - scene.camera.aim.x(), 0.0);
        approach_.incision = { { -25.0, 0.0, 0.0 }, { 25.0, 0.0, 0.0 } };
        approach_.directions.assign(2, Vec3::UnitY());
        approach_.wall_thickness_mm.clear();
        const Camera outside { .eye = { 0.0, -500.0, 0.0 }, .aim = Vec3::Zero(), .up = Vec3::UnitZ() };
        EXPECT_LT(planned_cut_camera(outside, approach_).eye.z(), -100.0) << "across: the eye goes to the feet";
        EXPECT_NEAR(planned_cut_camera(outside, approach_).eye.norm(), 500.0, 1e-9);
        EXPECT_TRUE(
            std::ranges::any_of(scene.surfaces, [](const SurfaceItem& item) { return item.name == "planned cut"; }));
    }

} // namespace planned_cut_test
} // namespace retractor::ui
