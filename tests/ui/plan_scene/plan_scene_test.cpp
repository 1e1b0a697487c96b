#include "ui/plan_scene/plan_scene.h"

#include "mesh/base/error.h"
#include "planner/plan/plan.h"
#include "tests/support/block_case.h"
#include "ui/plan_scene/field_map.h"
#include "ui/plan_scene/vessel_surfaces.h"
#include "ui/scene/vtk/identifier_picture.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace retractor::ui {
namespace plan_scene_test {

    /// Half a pixel along the target's outline, a few hundred pixels long, of some ten thousand in its area; and as
    /// much again for the samples of the rays.
    constexpr double kShareTolerance = 0.02;

    class PlanScene : public testing::Test {
    protected:
        static void SetUpTestSuite()
        {
            const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
            patient = std::make_unique<planner::Patient>(test_support::block_case("scene", phantom));
            field = std::make_unique<planner::PlannedField>(planner::plan_approach(
                *patient, test_support::block_approach(*patient->labels(), Eigen::Isometry3d::Identity(), 16.0)));
        }
        static void TearDownTestSuite()
        {
            field.reset();
            patient.reset();
        }
        static inline std::unique_ptr<planner::Patient> patient;
        static inline std::unique_ptr<planner::PlannedField> field;
    };

    TEST_F(PlanScene, TargetPixelsAgreeWithTheRaysOfThatEye)
    {
        ASSERT_EQ(field->status, planner::PlanStatus::done) << field->message;
        const Scene scene = surgeon_scene(*patient, *field);
        OffscreenRenderer renderer(make_offscreen_context());
        const TargetPixels pixels = target_pixels(renderer, scene);
        ASSERT_GT(pixels.alone, 5000U);
        const double rays = field->best_eye.picture_share;
        EXPECT_GT(rays, 0.05); // partly hidden, or the comparison says nothing
        EXPECT_LT(rays, 0.95);
        EXPECT_NEAR(pixels.share(), rays, kShareTolerance);
    }

    TEST_F(PlanScene, AnAssumedVesselMovesWithTheTissueAndIsDividedByTheCut)
    {
        const planner::Approach& approach = field->approach;
        const std::size_t middle = approach.incision.size() / 2;
        const Vec3 inward = approach.directions[middle];
        const Vec3 across = (approach.incision.back() - approach.incision.front()).cross(inward).normalized();
        const Vec3 under = approach.incision[middle] + 0.3 * approach.depth_mm * inward;
        planner::Case planned_case = patient->planned_case();
        planned_case.assumed_vessels
            = { { .name = "crossing", .line = { under - 25.0 * across, under + 25.0 * across } },
                  { .name = "elsewhere", .line = { under + 300.0 * across, under + 330.0 * across } } };
        const std::vector<SurfaceItem> at_rest = vessel_surfaces(planned_case);
        ASSERT_EQ(at_rest.size(), 2U);
        EXPECT_EQ(at_rest[0].name, "crossing (assumed place)");
        const std::vector<LineItem> lines = vessel_lines(planned_case);
        ASSERT_EQ(lines.size(), 2U);
        EXPECT_EQ(lines[0].points, planned_case.assumed_vessels[0].line);
        const std::vector<SurfaceItem> opened = vessel_surfaces(planned_case, *field);
        ASSERT_EQ(opened.size(), 2U) << "both sides of the divided vessel, and nothing far from the wound";
        double gap[2] = { 0.0, 0.0 }; // nearest to the cut on each side, away from it
        for (std::size_t n = 0; n < 2; ++n) {
            const Eigen::VectorXd side = (opened[n].mesh->vertices.rowwise() - under.transpose()) * across;
            gap[n] = side.cwiseAbs().minCoeff();
            EXPECT_TRUE((side.array() > 0.0).all() || (side.array() < 0.0).all()) << "it bridges the wound";
        }
        EXPECT_GT(gap[0] + gap[1], 0.5 * field->geometry.width_mm) << "its ends went with the lips";
        Scene scene;
        scene.surfaces = opened;
        scene.surfaces.push_back({ .name = "heart" });
        remove_vessels(scene);
        ASSERT_EQ(scene.surfaces.size(), 1U);
        EXPECT_EQ(scene.surfaces[0].name, "heart");
    }

    TEST_F(PlanScene, TheSurgeonLooksThroughTheOpeningAtTheTarget)
    {
        const Scene scene = surgeon_scene(*patient, *field);
        const Vec3 sight = (scene.camera.aim - scene.camera.eye).normalized();
        const Vec3 to_opening = field->geometry.centre - scene.camera.eye;
        // The line of sight passes through the opening.
        EXPECT_LT((to_opening - sight * sight.dot(to_opening)).norm(), 0.5 * field->geometry.length_mm);
        for (const fem::HookPatch& hook : field->hooks)
            EXPECT_TRUE(std::any_of(scene.surfaces.begin(), scene.surfaces.end(),
                [&](const SurfaceItem& item) { return item.name == hook.name && item.look.finish == Finish::metal; }));
        EXPECT_TRUE(scene.volumes.empty()); // the case has no CT
        EXPECT_NO_THROW(check_scene(scene));
    }

    TEST_F(PlanScene, ATargetThatIsOnlyEstimatedSaysSoBesideNumbersToo)
    {
        EXPECT_TRUE(estimated_lines(surgeon_scene(*patient, *field).legend).empty());
        planner::PlannedField guessed = *field;
        guessed.metrics.target_spec.label = "target";
        guessed.metrics.estimated = { "target" };
        const std::vector<LegendLine> lines = estimated_lines(overview_scene(*patient, guessed).legend);
        ASSERT_EQ(lines.size(), 1U);
        EXPECT_TRUE(lines.front().key.ends_with("(estimated)")) << lines.front().key;
        Scene seen = surgeon_scene(*patient, guessed);
        seen.legend = lines;
        const auto map = field_map(*patient, guessed, FieldMapKind::sight);
        ASSERT_TRUE(map);
        const std::vector<LegendLine> with_colours = with_map(seen, *map).legend;
        EXPECT_EQ(with_colours.size(), map->legend.size() + 1U);
        EXPECT_EQ(with_colours.back().key, lines.front().key);
    }

    TEST_F(PlanScene, NumbersThatAreNotToBeUsedAreNotInThePicture)
    {
        const auto has = [](const Scene& scene, std::string_view key) {
            return std::ranges::any_of(
                scene.legend, [&](const LegendLine& line) { return line.key.find(key) != std::string::npos; });
        };
        ASSERT_TRUE(has(surgeon_scene(*patient, *field), "force"));
        planner::PlannedField torn = *field;
        torn.metrics.hook_force_N = 9727.0;
        const Scene scene = surgeon_scene(*patient, torn);
        EXPECT_TRUE(has(scene, "NOT USABLE"));
        EXPECT_TRUE(has(scene, "target: "));
        EXPECT_FALSE(has(scene, "force"));
        EXPECT_FALSE(has(scene, "seen by"));
    }

    TEST_F(PlanScene, ViewsThatDoNotExistAreRefused)
    {
        EXPECT_THROW(view_picture(*patient, *field, "sideways", 320, 240), InputError);
        EXPECT_THROW(view_picture(*patient, *field, "slices", 320, 240), InputError); // no CT to slice
    }

} // namespace plan_scene_test
} // namespace retractor::ui
