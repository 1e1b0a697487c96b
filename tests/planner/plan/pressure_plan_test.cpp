// Plans under pressure: planner/wall/wall_pressure.h.

#include "planner/wall/wall_pressure.h"

#include "fem/statics/elastic_problem.h"
#include "mesh/base/error.h"
#include "planner/case/case_io.h"
#include "planner/plan/plan.h"
#include "tests/support/block_case.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {
namespace pressure_plan_test {

    std::string refusal(const std::function<void()>& f)
    {
        try {
            f();
        } catch (const InputError& error) {
            return error.where() + ": " + error.what();
        }
        return "nothing was thrown";
    }

    constexpr double kRegionMm = 30.0; ///< of the wide block, whose border holds it; of the narrow one: all
    constexpr double kNarrowMm = 90.0, kWideMm = 110.0;

    datasets::Phantom coarse_block(double width_mm = kNarrowMm)
    {
        datasets::BlockParameters block;
        block.size_mm = { width_mm, 70.0, width_mm };
        block.spacing_mm = Vec3::Constant(3.0);
        return datasets::make_block_phantom(block);
    }

    Approach approach_to(Patient& patient, double opening_mm)
    {
        const mesh::LabelVolume& labels = *patient.labels();
        Approach approach = test_support::block_approach(labels, Eigen::Isometry3d::Identity(), opening_mm);
        const bool wide = labels.grid.size[0] * labels.grid.spacing[0] > kWideMm;
        approach.sizing.region_mm = wide ? kRegionMm : 0.0;
        approach.sizing.corridor_edge_mm = 10.0;
        approach.sizing.coarse_edge_mm = 20.0;
        approach.view.eye_count = 1;
        return approach;
    }

    PlannedField planned(const Case& planned_case)
    {
        Patient patient(planned_case, {});
        return plan_approach(patient, approach_to(patient, 10.0));
    }

    TEST(PressurePlan, GasBelowTheWallPressesWhereTheWallBordersOnIt)
    {
        const datasets::Phantom phantom = coarse_block();
        Case planned_case = test_support::block_case("pressure", phantom);
        const PlannedField without = planned(planned_case);
        planned_case.pressures = { { "cavity", 0.5 } };
        const PlannedField with = planned(planned_case);
        ASSERT_EQ(with.status, PlanStatus::done) << with.message;
        ASSERT_EQ(with.metrics.pressures.size(), 1U);
        const PressureMetrics& pressure = with.metrics.pressures[0];
        // The block's lower side (y points into the body), but for what the cut has bared.
        constexpr double kSlab = 90.0 * 90.0, kShare = 0.1; // mm^2; the mesh rounds the block's rim
        EXPECT_NEAR(pressure.area_mm2, kSlab, kShare * kSlab);
        EXPECT_NEAR(pressure.force_N.y(), -0.5e-3 * kSlab, kShare * 0.5e-3 * kSlab);
        EXPECT_LT(pressure.force_N.x() * pressure.force_N.x() + pressure.force_N.z() * pressure.force_N.z(),
            kShare * pressure.force_N.squaredNorm());
        // The wall bulges outward, and more gas makes it bulge more.
        const auto height = [](const PlannedField& field) { return field.opening.displacement.col(1).mean(); };
        EXPECT_LT(height(with), height(without) - 0.1);
        ASSERT_TRUE(with.metrics.error.has_value());
        EXPECT_EQ(with.metrics.error->message, "");
        EXPECT_GT(with.metrics.error->opening_width_mm, 0.0);
        EXPECT_NE(pressure_text(pressure).find("pressure of cavity: 0.50 kPa on "), std::string::npos);
        EXPECT_NE(pressure_text(pressure).find("following the moving surface"), std::string::npos);
    }

    Vec3 sum_of(const std::vector<Vec3>& forces)
    {
        Vec3 sum = Vec3::Zero();
        for (const Vec3& force : forces)
            sum += force;
        return sum;
    }

    TEST(PressurePlan, HooksBearAllOfItWhereNothingElseHolds)
    {
        constexpr double kLinear = 1e-6, kNewton = 2e-3; // of the force: what the solvers leave
        const datasets::Phantom phantom = coarse_block();
        Case planned_case = test_support::block_case("pressure_hanging", phantom);
        planned_case.supports.region_border = false;
        planned_case.solution.elasticity = fem::Elasticity::linear;
        planned_case.pressures = { { "cavity", 0.3 } };
        const PlannedField linear = planned(planned_case);
        ASSERT_EQ(linear.status, PlanStatus::done) << linear.message;
        const Vec3 at_rest = linear.metrics.pressures.at(0).force_N;
        EXPECT_LT((sum_of(linear.opening.hook_forces_N) + at_rest).norm(), kLinear * at_rest.norm());
        EXPECT_NE(pressure_text(linear.metrics.pressures[0]).find("on the surface at rest"), std::string::npos);
        planned_case.solution.elasticity = fem::Elasticity::hyperelastic;
        const PlannedField field = planned(planned_case);
        ASSERT_EQ(field.status, PlanStatus::done) << field.message;
        const Points& moved = field.opening.displacement;
        const Eigen::VectorXd u = Eigen::Map<const Eigen::VectorXd>(moved.data(), moved.size());
        const Eigen::VectorXd force = fem::external_loads(field.problem).pressures.at(0).force(u);
        Vec3 pressed = Vec3::Zero();
        for (Eigen::Index v = 0; v < moved.rows(); ++v)
            pressed += force.segment<3>(3 * v);
        EXPECT_LT((sum_of(field.opening.hook_forces_N) + pressed).norm(), kNewton * pressed.norm());
        EXPECT_GT((pressed - at_rest).norm(), 2.0 * kNewton * pressed.norm())
            << "the surface has turned, and the force with it";
    }

    TEST(PressurePlan, GoesWithTensionAsLoadsAddUp)
    {
        constexpr double kSolver = 1e-6; // of the displacement
        const datasets::Phantom phantom = coarse_block(kWideMm);
        const auto moved = [&](double tension, double pressure_kPa) {
            Case planned_case = test_support::block_case("pressure_tension", phantom);
            planned_case.solution.elasticity = fem::Elasticity::linear;
            if (tension > 0.0)
                for (fem::Material& material : planned_case.materials)
                    material.pre_strain = { .kind = fem::PreStrainKind::equibiaxial, .strain = tension };
            planned_case.pressures = { { "cavity", pressure_kPa } };
            const PlannedField field = planned(planned_case);
            EXPECT_EQ(field.status, PlanStatus::done) << field.message;
            EXPECT_EQ(field.metrics.pressures.size(), pressure_kPa != 0.0 ? 1U : 0U);
            return field.opening.displacement;
        };
        const Points none = moved(0.0, 0.0), tense = moved(0.02, 0.0), pressed = moved(0.0, 0.3);
        EXPECT_GT((pressed - none).norm(), 0.01 * none.norm());
        EXPECT_LT((moved(0.02, 0.3) - (tense + pressed - none)).norm(), kSolver * none.norm());
    }

    TEST(PressurePlan, GoesWithContactAndHooksThatPullWithAForce)
    {
        const datasets::Phantom phantom = coarse_block(kWideMm);
        Case planned_case = test_support::block_case("pressure_contact", phantom);
        planned_case.contact = ContactMode::always;
        planned_case.pressures = { { "cavity", 0.2 } };
        Patient touching_patient(planned_case, {});
        const PlannedField touching = plan_approach(touching_patient, approach_to(touching_patient, 0.0), {}, {});
        ASSERT_EQ(touching.status, PlanStatus::done) << touching.message;
        EXPECT_GT(touching.metrics.contact->touching, 0U) << "the wall bulges, and its inner edges meet";
        EXPECT_EQ(touching.metrics.error->message, "");
        planned_case.contact = ContactMode::never;
        Patient patient(planned_case, {});
        Approach approach = approach_to(patient, 0.0);
        constexpr double kPull = 0.5, kAtRest = 5e-3; // N; of the force
        for (HookSpec& hook : approach.hooks)
            hook.pull.force_N = kPull;
        const PlannedField driven = plan_approach(patient, approach, {}, {});
        ASSERT_EQ(driven.status, PlanStatus::done) << driven.message;
        for (const HookForce& hook : driven.metrics.hooks)
            EXPECT_NEAR(hook.force_N / kPull, 1.0, kAtRest);
        EXPECT_EQ(driven.metrics.error->message, "");
    }

    constexpr Label kWall = 1, kCavity = 2, kOrgan = 3;

    /// Labels in layers across x from 0 on, so many voxels of each, under a block of wall 8 mm thick up to x = 0.
    mesh::LabelVolume layered(const std::vector<std::pair<Label, int>>& layers, const Vec3& spacing)
    {
        mesh::LabelVolume labels;
        labels.table = { { kWall, "wall", "muscle", mesh::Role::wall }, { kCavity, "cavity", "", mesh::Role::voxel },
            { kOrgan, "organ", "", mesh::Role::voxel } };
        const int below = static_cast<int>(std::lround(8.0 / spacing.x()));
        std::vector<Label> across(static_cast<std::size_t>(below), kWall);
        for (const auto& [label, count] : layers)
            across.insert(across.end(), static_cast<std::size_t>(count), label);
        labels.grid.spacing = spacing;
        labels.grid.size = { static_cast<int>(across.size()), static_cast<int>(std::ceil(8.0 / spacing.y())) + 1,
            static_cast<int>(std::ceil(8.0 / spacing.z())) + 1 };
        labels.grid.origin = Vec3((0.5 - below) * spacing.x(), 0.0, 0.0);
        for (int i = 0; i < labels.grid.size[1] * labels.grid.size[2]; ++i)
            labels.voxels.insert(labels.voxels.end(), across.begin(), across.end());
        return labels;
    }

    /// Areas of the face x = 0 of the block that the cavity presses on, and that it would but for a gap, mm^2.
    std::pair<double, double> bordering_area(const mesh::LabelVolume& labels)
    {
        mesh::TetMesh wall = mesh::kuhn_box(2, 2, 2, 4.0);
        wall.vertices.col(0).array() -= 8.0;
        const BorderingFaces bordering = faces_bordering(wall, labels, kCavity, {});
        const auto area = [&](const std::vector<mesh::TetFace>& faces) {
            const WallPressure pressure { { "cavity", faces, 1.0 }, {} };
            return pressure_metrics(wall, pressure, false).force_N;
        };
        return { -area(bordering.faces).x(), -area(bordering.behind_gap).x() };
    }

    TEST(PressurePlan, FacesAreThoseThatBorderOnTheLabelWithinVoxelsAsTheyLieAlongTheNormal)
    {
        const Vec3 flat(0.7, 0.7, 5.0); // a CT of thick slices
        using Areas = std::pair<double, double>;
        const Areas all(64.0, 0.0), none(0.0, 0.0), gap(0.0, 64.0);
        EXPECT_EQ(bordering_area(layered({ { kCavity, 9 } }, flat)), all);
        EXPECT_EQ(bordering_area(layered({ { kWall, 1 }, { kCavity, 9 } }, flat)), all) << "the mesh is smoother";
        EXPECT_EQ(bordering_area(layered({ { kWall, 6 }, { kCavity, 9 } }, flat)), none) << "4 mm of wall between them";
        EXPECT_EQ(bordering_area(layered({ { kOrgan, 1 }, { kCavity, 9 } }, flat)), none) << "a layer of one voxel";
        EXPECT_EQ(bordering_area(layered({ { 0, 1 }, { kCavity, 9 } }, flat)), gap);
        EXPECT_EQ(bordering_area(layered({ { 0, 1 }, { kWall, 1 }, { kCavity, 9 } }, flat)), none);
        EXPECT_EQ(bordering_area(layered({ { kWall, 1 }, { kCavity, 4 } }, Vec3(4.0, 4.0, 4.0))), all);
    }

    TEST(PressurePlan, WhatAGapLeavesOutIsSaid)
    {
        const PressureMetrics with_gap { .label = "cavity", .pressure_kPa = 1.0, .behind_gap_mm2 = 250.0 };
        EXPECT_NE(pressure_text(with_gap).find("no pressure on a further 2.5 cm2, because voxels without a label"),
            std::string::npos)
            << pressure_text(with_gap);
        EXPECT_EQ(pressure_text({ .label = "cavity" }).find("no pressure on"), std::string::npos);
    }

    TEST(PressurePlan, WhatCannotPressIsRefusedByName)
    {
        const datasets::Phantom phantom = coarse_block();
        const Case base = test_support::block_case("pressure refused", phantom);
        const auto refused = [&](const PressureSpec& spec) {
            Case planned_case = base;
            planned_case.pressures = { spec };
            return refusal([&] { (void)planned(planned_case); });
        };
        EXPECT_NE(refused({ "aorta", 1.0 }).find("there is no label \"aorta\""), std::string::npos);
        EXPECT_NE(refused({ "muscle", 1.0 }).find("belongs to the wall"), std::string::npos);
        for (const double kPa : { -101.0, 1e300, std::numeric_limits<double>::infinity() })
            EXPECT_NE(refused({ "cavity", kPa }).find("between -100 (suction) and 1000 kPa"), std::string::npos) << kPa;
        EXPECT_NE(
            refused({ "cavity", std::numeric_limits<double>::quiet_NaN() }).find("between -100 (suction) and 1000 kPa"),
            std::string::npos);
        EXPECT_NE(refused({ "target", 1.0 }).find("does not border on \"target\""), std::string::npos);
        Case planned_case = base;
        planned_case.pressures = { { "cavity", 1.0 }, { "cavity", 2.0 } };
        EXPECT_NE(refusal([&] { (void)planned(planned_case); }).find("is listed twice"), std::string::npos);
        planned_case.pressures.pop_back();
        planned_case.solution.near_mm = 30.0;
        EXPECT_NE(
            refusal([&] { (void)planned(planned_case); }).find("/solution/near_mm, pressures"), std::string::npos);
    }

    TEST(PressurePlan, CasesKeepIt)
    {
        Case planned_case = test_support::block_case("pressure kept", coarse_block());
        EXPECT_EQ(case_to_json(planned_case).find("pressures"), std::string::npos);
        planned_case.pressures = { { "cavity", 4.0 / 3.0 } };
        const Case back = case_from_json(case_to_json(planned_case), planned_case.folder);
        ASSERT_EQ(back.pressures.size(), 1U);
        EXPECT_EQ(back.pressures[0].label, "cavity");
        EXPECT_EQ(back.pressures[0].pressure_kPa, 4.0 / 3.0);
        EXPECT_EQ(pressure_from_text("left=lung=1.5").label, "left=lung");
        EXPECT_EQ(pressure_from_text("cavity=1.5").pressure_kPa, 1.5);
        for (const std::string text : { "cavity", "=1", "cavity=", "cavity=1.5mmHg" })
            EXPECT_NE(refusal([&] { (void)pressure_from_text(text); }).find("pressure: must be"), std::string::npos)
                << text;
    }

} // namespace pressure_plan_test
} // namespace retractor::planner
