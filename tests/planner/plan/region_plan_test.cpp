#include "planner/measures/region_text.h"
#include "planner/plan/plan.h"
#include "planner/plan/plan_forecast.h"
#include "tests/support/block_case.h"

#include "planner/approach/approach_templates.h"
#include "planner/approach/hooks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {
namespace region_plan_test {

    /// A block with a bar of bone along x in its muscle, which is held by a spine at one end, 120 mm from the middle.
    datasets::Phantom block_with_bar()
    {
        datasets::BlockParameters block;
        block.size_mm = { 260.0, 60.0, 200.0 };
        block.spacing_mm = { 2.5, 2.5, 2.5 };
        block.bone_bar = true;
        datasets::Phantom phantom = datasets::make_block_phantom(block);
        mesh::LabelVolume& labels = phantom.labels;
        const Label spine = 77;
        for (int k = 0; k < labels.grid.size[2]; ++k)
            for (int j = 0; j < labels.grid.size[1]; ++j)
                for (int i = 0; i < labels.grid.size[0]; ++i) {
                    Label& voxel = labels.voxels[labels.grid.offset(i, j, k)];
                    const mesh::LabelInfo* info = mesh::find_label(labels.table, voxel);
                    if (info != nullptr && info->role == mesh::Role::wall
                        && labels.grid.world(Vec3(i, j, k)).x() < -118.0)
                        voxel = spine;
                }
        labels.table.push_back({ spine, "spine", "bone", mesh::Role::wall });
        return phantom;
    }

    /// A cut along the bar beside it, whose hook on the bar's side bears on the bar.
    struct Cut {
        Case planned_case;

        explicit Cut(const std::string& name)
            : planned_case(test_support::block_case(name, block_with_bar()))
        {
            planned_case.supports = { .labels = { "spine" }, .region_border = true };
            Patient patient(planned_case);
            ApproachRequest request;
            request.name = "beside the bar";
            request.target.label = "target";
            request.sizing.corridor_edge_mm = 9.0;
            request.sizing.coarse_edge_mm = 15.0;
            request.view.eye_count = 1;
            const std::vector<Vec3> points { { 15.3, 0.0, 11.0 }, { 40.0, 0.0, 11.4 }, { 65.3, 0.0, 11.0 } };
            Approach approach = approach_from_points(*patient.labels(), points, request).approach;
            approach.hooks = make_hooks(approach, "2", 10.0);
            approach.retracted = { "cavity" };
            planned_case.approaches = { approach };
        }

        PlannedField plan(std::optional<double> region_mm, unsigned seed)
        {
            planned_case.approaches.front().sizing.region_mm = region_mm;
            planned_case.approaches.front().sizing.mesh_seed = seed;
            Patient patient(planned_case);
            return plan_all(patient, {}, { .error_bars = false, .find_region = true, .whole_wall_mm = whole_wall_mm })
                .front();
        }

        double whole_wall_mm = 0.0; ///< all walls count as large ones
    };

    TEST(RegionPlan, OnLongEdgesAWallThatIsNotLargeIsMeshedWholeWithoutDrafts)
    {
        Cut cut("whole");
        cut.whole_wall_mm = kWholeWallMm;
        cut.planned_case.approaches.front().sizing.corridor_edge_mm = 12.0; // as long as a draft's
        std::vector<double> forces, fine_forces;
        for (const unsigned seed : { 0U, 3U, 5U }) { // a single mesh of these edges may be off by a quarter
            const PlannedField found = cut.plan({}, seed);
            ASSERT_EQ(found.status, PlanStatus::done) << found.message;
            const RegionMetrics& region = found.metrics.region;
            EXPECT_EQ(region.ended_by, RegionEnd::whole);
            EXPECT_EQ(region.drafts, 0);
            EXPECT_EQ(region.rim_motion_mm, 0.0);
            EXPECT_FALSE(region.force_change.has_value());
            forces.push_back(found.metrics.hook_force_N);
            fine_forces.push_back(cut.plan(0.0, seed).metrics.hook_force_N);
        }
        std::ranges::sort(forces);
        std::ranges::sort(fine_forces);
        // The coarse model beyond 30 mm bears as much as fine tissue there: medians of the three meshes.
        constexpr double kCoarseError = 0.1; // single meshes of these edges differ by up to a quarter
        EXPECT_NEAR(forces[1], fine_forces[1], kCoarseError * fine_forces[1]);
    }

    TEST(RegionPlan, AWallThatDoesNotFitTheMemoryIsPlannedInARegionThatDoes)
    {
        Cut cut("memory");
        cut.planned_case.approaches.front().sizing.corridor_edge_mm = 12.0; // the whole wall, without drafts
        Patient patient(cut.planned_case);
        const Approach& approach = cut.planned_case.approaches.front();
        const ElementKind element = cut.planned_case.solution.element;
        PlanChecks checks { .error_bars = false, .find_region = true };
        std::string told; // the forecast of the mesh
        const Job job { .on_progress = [&](std::string_view stage, double) {
            if (stage.find(" tetrahedra, about ") != std::string_view::npos)
                told = stage;
        } };
        const PlannedField whole = plan_in_region(patient, approach, job, checks);
        ASSERT_EQ(whole.metrics.region.ended_by, RegionEnd::whole);
        const std::size_t at = told.find("(about ");
        ASSERT_NE(at, std::string::npos) << told;
        std::string digits;
        for (const char c : told.substr(at, told.find(" tetrahedra", at) - at))
            if (c >= '0' && c <= '9')
                digits += c;
        checks.memory_bytes = forecast_plan(0.95 * std::stod(digits), element).bytes;
        const PlannedField smaller = plan_in_region(patient, approach, {}, checks);
        ASSERT_EQ(smaller.status, PlanStatus::done) << smaller.message;
        EXPECT_EQ(smaller.metrics.region.ended_by, RegionEnd::memory);
        EXPECT_GE(smaller.metrics.region.drafts, 1);
        EXPECT_LT(smaller.metrics.tets, whole.metrics.tets);
        EXPECT_NE(region_text(smaller.metrics).find("needs more memory than there is"), std::string::npos);
    }

    TEST(RegionPlan, TheRimOfALargerRegionMovesLessAndAFoundRegionHoldsWhatMoves)
    {
        std::vector<double> forces, whole_forces;
        double force_change = 0.0;
        for (const unsigned seed : { 0U, 3U, 5U }) {
            Cut cut("region" + std::to_string(seed));
            const PlannedField near = cut.plan(20.0, seed), wide = cut.plan(60.0, seed), found = cut.plan({}, seed);
            for (const PlannedField* field : { &near, &wide, &found })
                ASSERT_EQ(field->status, PlanStatus::done) << field->message;
            EXPECT_EQ(near.metrics.region.ended_by, RegionEnd::given);
            EXPECT_EQ(near.metrics.region.region_mm, 20.0);
            EXPECT_EQ(near.metrics.region.drafts, 0);
            EXPECT_GT(near.metrics.region.rim_motion_mm, kStillRimMm);
            EXPECT_FALSE(near.metrics.region.rim_place.empty());
            EXPECT_LT(wide.metrics.region.rim_motion_mm, near.metrics.region.rim_motion_mm);
            const RegionMetrics& region = found.metrics.region;
            EXPECT_GE(region.region_mm, kFirstRegionMm);
            EXPECT_GE(region.drafts, 1);
            EXPECT_TRUE(region.ended_by == RegionEnd::still || region.ended_by == RegionEnd::whole)
                << to_string(region.ended_by);
            EXPECT_LT(region.rim_motion_mm, 1.5 * kStillRimMm); // the draft's element is another one
            EXPECT_TRUE(region.piercing.empty());
            forces.push_back(found.metrics.hook_force_N);
            whole_forces.push_back(cut.plan(1.3 * region.region_mm, seed).metrics.hook_force_N);
            force_change = std::max(force_change, region.force_change.value_or(0.0));
        }
        // A larger region changes the force by less than what the drafts say, and the chance of a mesh: medians of the
        // three meshes.
        constexpr double kMeshChance = 0.08; // single meshes of these edges differ by up to a quarter
        std::ranges::sort(forces);
        std::ranges::sort(whole_forces);
        EXPECT_NEAR(forces[1], whole_forces[1], (force_change + kMeshChance) * whole_forces[1])
            << forces[0] << ' ' << forces[2] << " and " << whole_forces[0] << ' ' << whole_forces[2];
    }

} // namespace region_plan_test
} // namespace retractor::planner
