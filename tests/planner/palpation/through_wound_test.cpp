#include "planner/palpation/through_wound.h"

#include "haptics/surroundings/finger_access.h"
#include "mesh/base/error.h"
#include "planner/measures/sight/instruments.h"
#include "planner/plan/plan.h"
#include "tests/support/block_case.h"
#include "tests/support/test_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace retractor::planner {
namespace through_wound_test {

    /// A flat target this far below a slit of this width, in a plate that is 20 mm thick: the finger that is felt
    /// touches the places that the measure counts.
    TEST(ThroughWound, TheFingerThatIsFeltReachesWhatTheMeasureSays)
    {
        constexpr double kFar = 90.0, kThick = 20.0, kTip = 4.0, kHalfTarget = 45.0;
        for (const double width : { 24.0, 40.0 })
            for (const double depth : { 35.0, 60.0 }) {
                const TriMesh left = test_support::box_surface({ -kFar, -kFar, -kThick }, { -0.5 * width, kFar, 0.0 }),
                              right = test_support::box_surface({ 0.5 * width, -kFar, -kThick }, { kFar, kFar, 0.0 });
                TriMesh target;
                target.vertices.resize(4, 3);
                target.vertices << -kHalfTarget, -kHalfTarget, -depth, kHalfTarget, -kHalfTarget, -depth, kHalfTarget,
                    kHalfTarget, -depth, -kHalfTarget, kHalfTarget, -depth;
                target.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
                OpeningGeometry opening;
                opening.along = Vec3::UnitY();
                opening.normal = Vec3::UnitZ();
                opening.length_mm = 100.0;
                opening.width_mm = width;
                std::vector<Occluder> walls;
                for (const TriMesh& lip : { left, right })
                    walls.push_back({ .name = "lip", .surface = lip, .labels = {}, .material = {}, .wall = true });
                const RayScene scene(target, walls, {});
                const std::vector<SurfaceSample> samples = surface_samples(target, 2000);
                const auto of_rays = static_cast<double>(finger_reach(scene, opening, samples).touched.size()) / 2000.0;
                const haptics::Opening gate { .centre = opening.centre,
                    .normal = opening.normal,
                    .along = opening.along,
                    .length_mm = opening.length_mm,
                    .width_mm = opening.width_mm };
                const haptics::FingerAccess access(
                    haptics::make_surroundings({ { "left", left }, { "right", right } }, gate, target, kFingerMm), gate,
                    { .thickness_mm = kFingerMm, .reach_mm = kFingerReachMm });
                const auto felt = static_cast<double>(std::ranges::count_if(samples, [&](const SurfaceSample& sample) {
                    return access.at(sample.position + kTip * Vec3::UnitZ(), kTip).fits;
                })) / 2000.0;
                EXPECT_GT(of_rays, 0.02);
                EXPECT_LT(of_rays, 0.98);
                // The ball at the tip lies 4 mm above the place, and the grid is off by 0.75 mm at edges.
                constexpr double kTolerance = 0.06;
                EXPECT_NEAR(felt, of_rays, kTolerance) << width << " mm wide, " << depth << " mm deep";
            }
    }

    TEST(ThroughWound, EverythingThatStaysIsRoundTheFinger)
    {
        const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
        Patient patient(test_support::block_case("through_wound", phantom));
        const PlannedField field = plan_approach(
            patient, test_support::block_approach(*patient.labels(), Eigen::Isometry3d::Identity(), 16.0));
        ASSERT_TRUE(is_measured(field)) << field.message;
        const PalpableThroughWound made = make_palpable_through(field, patient, { "cavity" });
        std::vector<std::string> names;
        for (const mesh::NamedSurface& surface : made.around) {
            names.push_back(surface.name);
            EXPECT_NE(surface.name, "cavity") << "it is palpated";
        }
        for (const char* name : { "skin", "muscle", "target", "chest wall beyond the model" })
            EXPECT_NE(std::ranges::find(names, name), names.end()) << name;
        EXPECT_FALSE(made.palpable.scene.sites.empty());
        EXPECT_EQ(made.palpable.scene.sites.front().name.substr(0, 6), "target");
        EXPECT_EQ(palpated_structure(field.approach, patient), std::vector<std::string> { "target" });
        Approach elsewhere = field.approach;
        elsewhere.target = { .label = {}, .centre = Vec3(1e4, 0.0, 0.0), .radius_mm = 5.0 };
        EXPECT_THROW(static_cast<void>(palpated_structure(elsewhere, patient)), InputError);
    }

} // namespace through_wound_test
} // namespace retractor::planner
