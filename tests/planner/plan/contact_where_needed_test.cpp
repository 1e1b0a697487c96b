#include "planner/plan/contact_where_needed.h"

#include "fem/error_estimation/error_estimate.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/opening.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/measures/verdict.h"
#include "planner/plan/opened_wound.h"
#include "planner/plan/plan.h"
#include "tests/support/block_case.h"
#include "tests/support/reference_problems.h"
#include "tests/support/wounds/pushed_lips.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {
namespace contact_where_needed_test {

    /// Share of the hook force that the residuals of two solutions leave.
    constexpr double kSolver = 2e-3;

    /// A field whose wall is the mesh of a problem, with hooks that prescribe their displacement.
    PlannedField field_of(fem::ElasticProblem problem)
    {
        PlannedField field;
        field.wall = problem.mesh;
        field.hooks = problem.hooks;
        field.problem = std::move(problem);
        return field;
    }

    PlannedField with_ten_nodes(PlannedField field)
    {
        field.problem = fem::with_midpoints(field.problem);
        return field;
    }

    /// A square that looks up, far wider than the blocks.
    TriMesh floor_at(double z)
    {
        TriMesh floor;
        floor.vertices.resize(4, 3);
        floor.vertices << -60, -60, z, 90, -60, z, 90, 90, z, -60, 90, z;
        floor.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
        return floor;
    }

    ContactSurfaces heart_at(double z) { return { .options = { .fixed = { floor_at(z) } }, .names = { "heart" } }; }

    /// A plate that is held at two sides; a hook on its top pushes its middle down.
    fem::ElasticProblem pushed_plate(double down_mm, double edge_mm)
    {
        constexpr double kLong = 30.0, kThick = 6.0, kRoundOff = 1e-9;
        const auto cells = [&](double length) { return static_cast<int>(std::lround(length / edge_mm)); };
        fem::ElasticProblem problem;
        problem.mesh = mesh::kuhn_box(cells(kLong), cells(kLong), cells(kThick), edge_mm);
        problem.material_of_label = { {}, test_support::material(0.05, 0.3) };
        problem.hooks = { { "push", 1, {}, Vec3(0.0, 0.0, -down_mm) } };
        for (VertexId v = 0; v < problem.mesh.vertices.rows(); ++v) {
            const Vec3 x = problem.mesh.vertices.row(v).transpose();
            if (x.x() < kRoundOff || x.x() > kLong - kRoundOff)
                problem.supports.fixed.push_back(v);
            else if (x.z() > kThick - kRoundOff && (x.head<2>() - Eigen::Vector2d(15.0, 15.0)).norm() < 6.5)
                problem.hooks[0].nodes.push_back(v);
        }
        return problem;
    }

    /// The plate with a blade in contact in place of its hook.
    PlannedField plate_under_blade(double down_mm)
    {
        PlannedField field = field_of(pushed_plate(down_mm, 3.0));
        field.approach.hooks = { HookSpec { .name = "push", .side = 1, .hold = HookHold::contact } };
        add_blade(field.problem, 0, mesh::boundary_faces(field.wall), {},
            { .name = "push",
                .middle = Vec3(15.0, 15.0, 6.0),
                .along = Vec3::UnitX(),
                .deep = Vec3::UnitY(),
                .outward = -Vec3::UnitZ(),
                .width_mm = 8.0,
                .height_mm = 8.0 });
        return field;
    }

    OpenOnce opener_of(const PlannedField& field)
    {
        return [&field](const std::optional<fem::ContactOptions>& contact, const OpenedWall* start,
                   const StageTest& goes_on, const Job& part) {
            fem::OpeningOptions options = opening_options(SolverSettings {});
            options.contact = contact;
            return open_wall(field, 0.0, {}, options, part, start, goes_on);
        };
    }

    ContactOpening opened(
        const PlannedField& field, ContactMode mode, const ContactSurfaces& surfaces = {}, const Job& job = {})
    {
        return open_with_contact(field.problem, mode, surfaces, opener_of(field), true, job);
    }

    double force_of(const ContactOpening& solved) { return solved.opened.opening.hook_forces_N.at(0).norm(); }

    /// How far the bottom of the plate, at z = 0, comes down.
    double bottom_motion_mm(const PlannedField& field, const ContactOpening& solved)
    {
        double motion = 0.0;
        for (Eigen::Index v = 0; v < field.wall.vertices.rows(); ++v)
            if (field.wall.vertices(v, 2) == 0.0)
                motion = std::max(motion, -solved.opened.opening.displacement(v, 2));
        return motion;
    }

    void expect_same(const ContactOpening& a, const ContactOpening& b)
    {
        const Points &u = a.opened.opening.displacement, &v = b.opened.opening.displacement;
        EXPECT_LT((u - v).norm(), kSolver * v.norm());
        EXPECT_NEAR(force_of(a), force_of(b), kSolver * force_of(b));
    }

    TEST(ContactWhereNeeded, LipsThatNothingPushesTogetherAreSolvedWithout)
    {
        for (const bool ten_nodes : { false, true }) {
            PlannedField field = field_of(test_support::lips_pushed(-2.0).problem);
            if (ten_nodes)
                field = with_ten_nodes(std::move(field));
            const ContactOpening automatic = opened(field, ContactMode::automatic),
                                 without = opened(field, ContactMode::never);
            EXPECT_FALSE(without.contact);
            ASSERT_TRUE(automatic.contact);
            EXPECT_EQ(automatic.contact->needed, false) << automatic.contact->largest_penetration_mm;
            EXPECT_FALSE(automatic.contact->computed);
            EXPECT_LE(automatic.contact->largest_penetration_mm, kPenetrationToleranceMm);
            EXPECT_EQ(automatic.opened.opening.displacement, without.opened.opening.displacement);
            EXPECT_EQ(automatic.opened.opening.hook_forces_N, without.opened.opening.hook_forces_N);
        }
    }

    TEST(ContactWhereNeeded, LipsThatAreClosedOnThemselvesAreSolvedWithContact)
    {
        for (const bool ten_nodes : { false, true }) {
            PlannedField field = field_of(test_support::lips_pushed(2.0).problem);
            if (ten_nodes)
                field = with_ten_nodes(std::move(field));
            const ContactOpening automatic = opened(field, ContactMode::automatic),
                                 asked = opened(field, ContactMode::always),
                                 without = opened(field, ContactMode::never);
            ASSERT_TRUE(is_usable(automatic.opened.opening)) << automatic.opened.opening.message;
            ASSERT_TRUE(is_usable(asked.opened.opening)) << asked.opened.opening.message;
            EXPECT_EQ(automatic.contact->needed, true);
            EXPECT_FALSE(asked.contact->needed);
            EXPECT_TRUE(automatic.contact->computed && asked.contact->computed);
            EXPECT_GT(automatic.contact->touching, 5U);
            EXPECT_EQ(automatic.contact->touching, asked.contact->touching);
            EXPECT_EQ(automatic.contact->with, "");
            expect_same(automatic, asked);
            EXPECT_GT(force_of(automatic), force_of(without)) << "harder to push";
        }
    }

    TEST(ContactWhereNeeded, AWallIsHeldOffARigidOrgan)
    {
        for (const double edge : { 3.0, 2.0 }) {
            const PlannedField field = field_of(pushed_plate(2.0, edge));
            const ContactOpening without = opened(field, ContactMode::never);
            ASSERT_TRUE(is_usable(without.opened.opening)) << without.opened.opening.message;
            // What the bottom, at z = 0, passes through a plane is known.
            const double bottom = bottom_motion_mm(field, without);
            ASSERT_GT(bottom, 0.5);
            const double gap = 0.5 * bottom;
            const Penetration found
                = find_penetration(field.problem, heart_at(-gap), without.opened.opening.displacement);
            EXPECT_NEAR(found.depth_mm, bottom - gap, 1e-9);
            EXPECT_EQ(found.with, "heart");
            EXPECT_NEAR(found.at.z(), -bottom, 1e-9);
            const ContactOpening automatic = opened(field, ContactMode::automatic, heart_at(-gap)),
                                 asked = opened(field, ContactMode::always, heart_at(-gap));
            ASSERT_TRUE(is_usable(automatic.opened.opening)) << automatic.opened.opening.message;
            EXPECT_EQ(automatic.contact->needed, true);
            EXPECT_TRUE(automatic.contact->computed);
            EXPECT_EQ(automatic.contact->with, "heart");
            EXPECT_LT(automatic.contact->largest_penetration_mm, 0.1 * (bottom - gap));
            expect_same(automatic, asked);
            EXPECT_GT(force_of(automatic), force_of(without));
            // The organ farther away, by more than the plate comes down, or by the tolerance less.
            for (const double off : { 1.1 * bottom, bottom - 0.5 * kPenetrationToleranceMm }) {
                const ContactOpening free = opened(field, ContactMode::automatic, heart_at(-off));
                EXPECT_EQ(free.contact->needed, false);
                EXPECT_EQ(free.opened.opening.displacement, without.opened.opening.displacement);
            }
        }
    }

    TEST(ContactWhereNeeded, AnOrganGivesWayUntilItBearsTwoNewtons)
    {
        // By hand: 2 N x 0.75 / (2 x 0.0054 N/mm2 x 30 mm).
        EXPECT_NEAR(gives_way_mm(test_support::material(0.0054, 0.5)), 4.63, 0.01);
        EXPECT_LT(gives_way_mm(test_support::material(1.0, 0.45)), 0.03) << "a vessel";
        EXPECT_EQ(gives_way_mm(test_support::material(1e-4, 0.3)), kMostGivesWayMm);
    }

    TEST(ContactWhereNeeded, ASoftOrganGivesWayButNotForEver)
    {
        constexpr double kDepthMm = 3.0;
        const PlannedField field = field_of(pushed_plate(8.0, 3.0));
        const ContactOpening without = opened(field, ContactMode::never);
        ASSERT_TRUE(is_usable(without.opened.opening)) << without.opened.opening.message;
        const double bottom = bottom_motion_mm(field, without);
        ASSERT_GT(bottom, kDepthMm + 0.2);
        ContactSurfaces soft = heart_at(-(bottom - kDepthMm));
        soft.gives_way_mm = { kDepthMm + 0.1 };
        const ContactOpening shallow = opened(field, ContactMode::automatic, soft);
        EXPECT_EQ(shallow.contact->needed, false);
        EXPECT_EQ(shallow.contact->with, "heart");
        EXPECT_NEAR(shallow.contact->largest_penetration_mm, kDepthMm, 1e-9);
        EXPECT_EQ(shallow.opened.opening.displacement, without.opened.opening.displacement);
        ContactSurfaces firmer = soft;
        firmer.gives_way_mm = { kDepthMm - 0.1 };
        EXPECT_EQ(opened(field, ContactMode::automatic, firmer).contact->needed, true);
        // A bone that the wall passes through less deeply is not hidden by the heart, and is held off alone.
        ContactSurfaces both = soft, bone = heart_at(-(bottom - 1.0));
        both.options.fixed.push_back(floor_at(-(bottom - 1.0)));
        both.names.emplace_back("vertebra");
        both.gives_way_mm.push_back(0.0);
        const ContactOpening on_both = opened(field, ContactMode::automatic, both),
                             on_bone = opened(field, ContactMode::automatic, bone);
        EXPECT_EQ(on_both.contact->needed, true);
        expect_same(on_both, on_bone);
        both.tolerance_mm = 1.5;
        EXPECT_EQ(opened(field, ContactMode::automatic, both).contact->needed, false) << "known no better";
    }

    /// With contact the plate begins where the blade has pressed it through the organ.
    TEST(ContactWhereNeeded, AWallUnderABladeIsHeldOffAnOrganAsFromRest)
    {
        const PlannedField field = plate_under_blade(1.5);
        ASSERT_FALSE(field.problem.blades.empty());
        const ContactSurfaces heart = heart_at(-0.5);
        const ContactOpening automatic = opened(field, ContactMode::automatic, heart),
                             from_rest = opened(field, ContactMode::always, heart);
        ASSERT_TRUE(automatic.contact && from_rest.contact);
        EXPECT_EQ(automatic.contact->needed, true);
        EXPECT_TRUE(automatic.contact->computed) << automatic.contact->message;
        EXPECT_GT(automatic.contact->touching, 0U);
        expect_same(automatic, from_rest);
    }

    TEST(ContactWhereNeeded, OtherTissueIsHeldOffFromTheOpeningOfTheFirstAsFromRest)
    {
        PlannedField field = plate_under_blade(1.5);
        const ContactSurfaces heart = heart_at(-0.5);
        ContactSurfaces both = heart; // the lung before the heart gives way and is not touched
        both.options.fixed.push_back(floor_at(-0.2));
        both.names.emplace_back("lung");
        both.gives_way_mm = { 0.0, 5.0 };
        const ContactOpening first = opened(field, ContactMode::automatic, heart);
        EXPECT_EQ(first.opened.touchable, std::optional(std::vector<std::string> { "heart" }));
        EXPECT_FALSE(opened(field, ContactMode::never).opened.touchable);
        for (fem::Material& material : field.problem.material_of_label)
            material.youngs_modulus_MPa *= 1.5;
        const std::optional<ContactOpening> stiffer
            = open_touching_from(first.opened, field.problem, both, opener_of(field), {});
        ASSERT_TRUE(stiffer && stiffer->contact);
        EXPECT_EQ(stiffer->contact->needed, true);
        EXPECT_TRUE(stiffer->contact->computed);
        EXPECT_EQ(stiffer->opened.touchable, first.opened.touchable);
        const ContactOpening from_rest = opened(field, ContactMode::always, heart);
        expect_same(*stiffer, from_rest);
        EXPECT_GT(force_of(*stiffer), 1.2 * force_of(first));
        both.gives_way_mm = { 0.0, 0.1 };
        EXPECT_FALSE(open_touching_from(first.opened, field.problem, both, opener_of(field), {}))
            << "the lung gives way no longer";
        std::atomic<bool> cancelled { true };
        Job job;
        job.cancel = &cancelled;
        const std::optional<ContactOpening> none
            = open_touching_from(first.opened, field.problem, both, opener_of(field), job);
        ASSERT_TRUE(none);
        EXPECT_EQ(none->opened.opening.status, fem::OpeningStatus::cancelled);
    }

    /// One search at the end would take a point so deep behind a face to have been there all along.
    TEST(ContactWhereNeeded, ABodyIsSeenToPassDeepIntoAnOrgan)
    {
        fem::ElasticProblem problem = pushed_plate(1.0, 3.0);
        constexpr double kGap = 2.0, kDown = 11.0;
        Points moved = Points::Zero(problem.mesh.vertices.rows(), 3);
        moved.col(2).setConstant(-kDown);
        moved.col(0).setConstant(4.0);
        const Penetration found = find_penetration(problem, heart_at(-kGap), moved);
        EXPECT_NEAR(found.depth_mm, kDown - kGap, 1e-9);
        EXPECT_EQ(found.with, "heart");
        // An overlap at rest is kept, and is no penetration.
        const Penetration overlapping = find_penetration(problem, heart_at(0.3), 0.0 * moved);
        EXPECT_EQ(overlapping.depth_mm, 0.0);
        EXPECT_NEAR(overlapping.overlap_at_rest_mm, 0.3, 1e-9);
    }

    TEST(ContactWhereNeeded, WithoutAnEquilibriumTheAnswerWithoutContactIsKeptAndMarked)
    {
        // The hook holds the bottom too, and no force keeps what is prescribed off the organ.
        fem::ElasticProblem problem = pushed_plate(1.5, 3.0);
        for (VertexId v = 0; v < problem.mesh.vertices.rows(); ++v)
            if (problem.mesh.vertices(v, 2) == 0.0
                && (problem.mesh.vertices.row(v).head<2>().transpose() - Eigen::Vector2d(15.0, 15.0)).norm() < 6.5)
                problem.hooks[0].nodes.push_back(v);
        const PlannedField field = field_of(problem);
        const ContactOpening automatic = opened(field, ContactMode::automatic, heart_at(-0.7)),
                             without = opened(field, ContactMode::never);
        ASSERT_TRUE(automatic.contact);
        EXPECT_EQ(automatic.contact->needed, true);
        EXPECT_FALSE(automatic.contact->computed);
        EXPECT_EQ(automatic.contact->touching, 0U);
        EXPECT_NEAR(automatic.contact->largest_penetration_mm, 0.8, 1e-9);
        EXPECT_EQ(automatic.contact->with, "heart");
        EXPECT_NE(automatic.contact->message.find("collided"), std::string::npos) << automatic.contact->message;
        EXPECT_EQ(automatic.opened.opening.displacement, without.opened.opening.displacement);
        EXPECT_EQ(automatic.opened.opening.status, fem::OpeningStatus::converged);
    }

    TEST(ContactWhereNeeded, BladesThatFindNoEquilibriumHoldTheTissueAndSaySo)
    {
        PlannedField field = plate_under_blade(1.0);
        const std::vector<VertexId> held = field.hooks[0].nodes;
        ASSERT_FALSE(field.problem.blades.empty());
        for (const bool found : { true, false }) {
            int solved = 0;
            const ContactOpening answer = solve_or_hold(field, [&] {
                ++solved;
                ContactOpening opening;
                opening.opened.opening.status = field.problem.blades.empty() || found
                    ? fem::OpeningStatus::converged
                    : fem::OpeningStatus::not_converged;
                return opening;
            });
            EXPECT_EQ(answer.opened.opening.status, fem::OpeningStatus::converged);
            EXPECT_EQ(solved, found ? 1 : 2);
            EXPECT_EQ(field.contact_was_lost, !found);
            EXPECT_EQ(field.problem.blades.empty(), !found);
            EXPECT_EQ(field.approach.hooks[0].hold, found ? HookHold::contact : HookHold::fixed);
        }
        EXPECT_EQ(field.problem.hooks[0].nodes, held);
        EXPECT_EQ(field.problem.mesh.vertices.rows(), field.wall.vertices.rows());
        const fem::OpeningResult opened = fem::Opening(field.problem, {}).open(field.problem.hooks);
        EXPECT_EQ(opened.status, fem::OpeningStatus::converged) << opened.message;
    }

    TEST(ContactWhereNeeded, BladesThatWouldBearAnImpossibleForceAreNotSolvedForHolding)
    {
        for (const double held_N : { 1.9 * kImpossibleForceN, 2.1 * kImpossibleForceN }) {
            PlannedField field = plate_under_blade(1.0);
            const bool impossible = held_N > 2.0 * kImpossibleForceN; // in four-node elements
            int solved = 0;
            const ContactOpening answer = solve_or_hold(field, [&] {
                ++solved;
                ContactOpening opening;
                opening.opened.held_force_N = held_N;
                opening.opened.opening.status = fem::OpeningStatus::not_converged;
                return opening;
            });
            EXPECT_EQ(solved, impossible ? 1 : 2);
            EXPECT_EQ(field.contact_was_lost, !impossible);
            EXPECT_EQ(answer.opened.opening.message.find("would bear 4200 N") != std::string::npos, impossible)
                << answer.opened.opening.message;
        }
    }

    TEST(ContactWhereNeeded, ACancelledJobEndsIt)
    {
        const std::atomic<bool> cancel { true };
        const Job job { .on_progress = {}, .cancel = &cancel };
        const PlannedField field = with_ten_nodes(field_of(pushed_plate(1.0, 3.0)));
        const ContactOpening solved = opened(field, ContactMode::automatic, heart_at(-0.1), job);
        EXPECT_EQ(solved.opened.opening.status, fem::OpeningStatus::cancelled);
    }

    /// A plan of a wound that nothing touches has the same bits as without contact.
    TEST(ContactWhereNeeded, APlanTestsForContactUnlessItIsRefused)
    {
        const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
        Case planned_case = test_support::block_case("touches", phantom);
        const auto planned = [&](ContactMode contact, double near_mm) {
            planned_case.contact = contact;
            planned_case.solution.near_mm = near_mm;
            Patient patient(planned_case);
            return plan_approach(patient,
                test_support::block_approach(*patient.labels(), Eigen::Isometry3d::Identity(), 10.0), {},
                { .error_bars = false });
        };
        EXPECT_EQ(Case {}.contact, ContactMode::automatic);
        const PlannedField automatic = planned(ContactMode::automatic, 0.0), without = planned(ContactMode::never, 0.0);
        ASSERT_EQ(automatic.status, PlanStatus::done) << automatic.message;
        EXPECT_FALSE(without.metrics.contact);
        ASSERT_TRUE(automatic.metrics.contact);
        EXPECT_EQ(automatic.metrics.contact->needed, false) << automatic.metrics.contact->largest_penetration_mm;
        EXPECT_EQ(automatic.metrics.hook_force_N, without.metrics.hook_force_N);
        EXPECT_EQ(automatic.opening.displacement, without.opening.displacement);
        const PlannedField near = planned(ContactMode::automatic, 20.0);
        ASSERT_EQ(near.status, PlanStatus::done) << near.message;
        ASSERT_TRUE(near.metrics.contact);
        EXPECT_EQ(near.metrics.contact->needed, false);
    }

} // namespace contact_where_needed_test
} // namespace retractor::planner
