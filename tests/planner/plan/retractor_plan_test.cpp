#include "planner/plan/plan.h"

#include "fem/statics/opening.h"
#include "mesh/base/error.h"
#include "planner/approach/retractors.h"
#include "planner/measures/metrics.h"
#include "planner/measures/verdict.h"
#include "planner/measures/volume_failures.h"
#include "tests/support/block_case.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace retractor::planner {
namespace retractor_plan_test {

    constexpr double kOpeningMm = 10.0;

    PlannedField plan_with(const RetractorDrive& drive, const SolverSettings& choice, HookHold hold = HookHold::contact,
        unsigned mesh_seed = 0, double opening_time_s = kMostOpeningS)
    {
        const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
        Case planned_case = test_support::block_case("retractor", phantom);
        planned_case.solution = choice;
        Patient patient(planned_case, {});
        Approach approach = test_support::block_approach(*patient.labels(), Eigen::Isometry3d::Identity(), 0.0);
        approach.hooks.clear();
        approach.sizing.region_mm = 30.0; // the border of the region holds the wall
        approach.sizing.mesh_seed = mesh_seed;
        if (choice.element != ElementKind::p1)
            approach.sizing.corridor_edge_mm = 12.0; // contact of ten-node elements takes its time
        RetractorKind kind = find_retractor(built_in_retractors(), "midcab");
        kind.blade_width_mm = 20.0;
        approach.retractor = make_retractor(approach, kind, drive);
        approach.retractor->hold = hold;
        return plan_approach(patient, approach, {}, { .opening_time_s = opening_time_s });
    }

    TEST(RetractorPlan, TheBladesAreInBalanceAndReported)
    {
        for (const ElementKind element : { ElementKind::p1, ElementKind::mixed }) {
            const PlannedField field = plan_with({ .opening_mm = kOpeningMm }, { .element = element });
            ASSERT_EQ(field.status, PlanStatus::done) << field.message;
            ASSERT_TRUE(field.metrics.retractor.has_value());
            const RetractorMetrics& retractor = *field.metrics.retractor;
            EXPECT_EQ(retractor.kind, "midcab");
            EXPECT_NEAR(retractor.opening_mm, kOpeningMm, 1e-9);
            ASSERT_EQ(retractor.blades.size(), 2U);
            const double force = retractor.blades[0].force_N.norm();
            EXPECT_GT(force, 0.0);
            constexpr double kBalance = 0.02; // as plans with blades in contact ask for
            EXPECT_LE(retractor.residual_force_N, kBalance * force * 1.01);
            EXPECT_NEAR(retractor.blades[1].force_N.norm(), force, 2.0 * kBalance * force);
            EXPECT_LT(retractor.blades[0].force_N.dot(retractor.blades[1].force_N), 0.0);
            for (const BladeMetrics& blade : retractor.blades) {
                EXPECT_LE(std::abs(blade.turn_deg), 10.0 + 1e-9);
                EXPECT_LT(blade.lip_deviation_mm, kOpeningMm);
            }
            ASSERT_EQ(field.metrics.lip_deviation.size(), 2U);
            for (const LipDeviation& lip : field.metrics.lip_deviation) {
                EXPECT_LT(lip.mean_mm, lip.largest_mm);
                EXPECT_LT(lip.largest_mm, kOpeningMm);
                EXPECT_GE(lip.at_mm, lip.from_mm);
                EXPECT_LE(lip.at_mm, lip.to_mm);
            }
            ASSERT_FALSE(field.metrics.tissue_strain.empty());
            for (const TissueStrain& tissue : field.metrics.tissue_strain) {
                EXPECT_GT(tissue.strain, 0.0) << tissue.tissue;
                EXPECT_NE(tissue.place.find("the incision"), std::string::npos) << tissue.place;
            }
            const auto document = metrics_document({ field.metrics });
            const auto& json = document["approaches"][0]["retractor"];
            EXPECT_EQ(json["kind"], "midcab");
            EXPECT_EQ(json["blades"][0]["force_N"].size(), 3U);
            EXPECT_EQ(json["blades"][0]["hold"], "contact");
            EXPECT_GT(json["blades"][0]["pressure_mean_kPa"].get<double>(), 0.0);
            EXPECT_GE(json["blades"][0]["pressure_largest_kPa"].get<double>(),
                json["blades"][0]["pressure_mean_kPa"].get<double>());
            EXPECT_FALSE(json["contact_was_lost"].get<bool>());
            EXPECT_TRUE(field.metrics.error && field.metrics.error->message.empty())
                << (field.metrics.error ? field.metrics.error->message : "no bars");
            EXPECT_NE(retractor_text(field.metrics).find("left blade"), std::string::npos)
                << retractor_text(field.metrics);
        }
    }

    TEST(RetractorPlan, VolumesOfFourNodeElementsAreJudgedWithTheirNeighbours)
    {
        const mesh::LabelTable table = datasets::make_block_phantom(test_support::small_block()).labels.table;
        for (const ElementKind element : { ElementKind::p1, ElementKind::mixed }) {
            const PlannedField field = plan_with({ .opening_mm = kOpeningMm }, { .element = element }, HookHold::fixed);
            ASSERT_TRUE(field.metrics.volume_failures.has_value()) << field.message;
            const std::vector<double>& each = field.opening.volume_ratio;
            const VolumeFailures alone = find_volume_failures(field.wall, each, table, 0);
            const VolumeFailures together
                = find_volume_failures(field.wall, averaged_volume_ratios(field.wall, each), table, 0);
            ASSERT_LT(together.share, alone.share) << "neighbours cancel, or the comparison says nothing";
            EXPECT_EQ(field.metrics.volume_failures->share, element == ElementKind::p1 ? together.share : alone.share);
        }
    }

    TEST(RetractorPlan, AnOpeningWhoseTimeIsUpIsMarkedAndNotWithoutAState)
    {
        for (const ElementKind element : { ElementKind::p1, ElementKind::mixed }) {
            const PlannedField field
                = plan_with({ .opening_mm = kOpeningMm }, { .element = element }, HookHold::contact, 0, 0.0);
            EXPECT_EQ(field.status, PlanStatus::not_converged);
            EXPECT_TRUE(field.ended_by_time);
            EXPECT_NE(field.message.find("no equilibrium was found in 0 s"), std::string::npos) << field.message;
            EXPECT_EQ(field.opening.displacement.rows(), field.wall.vertices.rows());
            EXPECT_TRUE(field.opening.displacement.allFinite());
            EXPECT_FALSE(why_not_to_use(field.metrics).empty());
        }
    }

    TEST(RetractorPlan, ElementsThatBladesTurnInsideOutAreMadeStifferUntilTheyResist)
    {
        constexpr double kFarMm = 30.0; // more than four-node elements at the rims of fixed blades bear
        std::size_t stiffened = 0;
        for (const unsigned seed : { 0U, 1U }) {
            const PlannedField field
                = plan_with({ .opening_mm = kFarMm }, { .element = ElementKind::p1 }, HookHold::fixed, seed);
            ASSERT_EQ(field.status, PlanStatus::done) << field.message;
            EXPECT_EQ(field.metrics.inverted_elements, 0);
            stiffened += field.opening.stiffened.size();
            for (const fem::StiffenedElement& element : field.opening.stiffened)
                EXPECT_NE(field.problem.mesh.labels[static_cast<std::size_t>(element.tet)],
                    field.wall.labels[static_cast<std::size_t>(element.tet)]);
            if (!field.opening.stiffened.empty()) {
                EXPECT_NE(field.message.find("turned inside out are computed"), std::string::npos) << field.message;
            }
            // Later solutions of the field's problem are of the same tissue.
            fem::Opening opening(field.problem, { .elasticity = fem::Elasticity::corotational });
            opening.start_from(field.opening.displacement);
            const fem::OpeningResult again = opening.open(field.problem.hooks);
            ASSERT_EQ(again.status, fem::OpeningStatus::converged) << again.message;
            constexpr double kSame = 1e-3; // both are solved to a residual of 1e-4
            for (std::size_t h = 0; h < again.hook_forces_N.size(); ++h)
                EXPECT_LT((again.hook_forces_N[h] - field.opening.hook_forces_N[h]).norm(),
                    kSame * field.metrics.hook_force_N);
        }
        EXPECT_GT(stiffened, 0U) << "this opening turns no element over: open farther";
    }

    TEST(RetractorPlan, AFixedBladeHasNoPressure)
    {
        const PlannedField field
            = plan_with({ .opening_mm = kOpeningMm }, { .element = ElementKind::p1 }, HookHold::fixed);
        ASSERT_EQ(field.status, PlanStatus::done) << field.message;
        ASSERT_TRUE(field.metrics.retractor.has_value());
        EXPECT_FALSE(field.metrics.retractor->blades[0].pressure.has_value());
        const auto document = metrics_document({ field.metrics });
        EXPECT_EQ(document["approaches"][0]["retractor"]["blades"][0]["hold"], "fixed");
        EXPECT_FALSE(document["approaches"][0]["retractor"]["blades"][0].contains("pressure_mean_kPa"));
    }

    TEST(RetractorPlan, TheForceOfBladesInContactHangsLittleOnTheMesh)
    {
        // Three meshes of the same sizes: what differs is chance.
        std::vector<double> forces;
        for (const unsigned seed : { 0U, 1U, 2U }) {
            const PlannedField field
                = plan_with({ .opening_mm = kOpeningMm }, { .element = ElementKind::p1 }, HookHold::contact, seed);
            ASSERT_EQ(field.status, PlanStatus::done) << field.message;
            ASSERT_TRUE(field.metrics.retractor && !field.metrics.retractor->contact_was_lost);
            forces.push_back(field.metrics.retractor->blades[0].force_N.norm());
        }
        const auto [least, most] = std::ranges::minmax(forces);
        constexpr double kByChance = 0.15; // the accuracy that plans promise for forces
        EXPECT_LT(most - least, kByChance * most) << least << " to " << most << " N";
    }

    TEST(RetractorPlan, ACondensedRegionIsRefused)
    {
        EXPECT_THROW((void)plan_with({ .opening_mm = kOpeningMm },
                         { .elasticity = fem::Elasticity::hyperelastic, .near_mm = 20.0 }),
            InputError);
    }

} // namespace retractor_plan_test
} // namespace retractor::planner
