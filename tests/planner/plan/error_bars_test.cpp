#include "planner/plan/error_bars.h"

#include "fem/error_estimation/error_estimate.h"
#include "fem/statics/opening.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "planner/plan/plan.h"
#include "planner/wall/field_geometry.h"
#include "tests/support/block_case.h"

#include <Eigen/Geometry>

#include <gtest/gtest.h>

#include <string>

namespace retractor::planner {
namespace error_bars_test {

    /// A stiff layer of elements fifty times as wide as they are thick on a soft one, which is held from below; two
    /// hooks draw it apart.
    fem::ElasticProblem flat_sheet()
    {
        constexpr double kEdge = 10.0, kFlat = 0.02, kTop = 2.0 * kEdge * kFlat, kRoundOff = 1e-9;
        fem::ElasticProblem sheet;
        sheet.mesh = mesh::kuhn_box(6, 4, 2, kEdge);
        sheet.mesh.vertices.col(2) *= kFlat;
        for (std::size_t t = 0; t < sheet.mesh.tet_count(); ++t)
            for (const VertexId v : sheet.mesh.tet(static_cast<TetId>(t)))
                if (sheet.mesh.vertices(v, 2) > kTop - kRoundOff)
                    sheet.mesh.labels[t] = 2;
        sheet.material_of_label = { {}, { "soft", 0.04, 0.0, 1e-9, "test" }, { "stiff", 2e5, 0.0, 1e-9, "test" } };
        sheet.hooks = { { "left", -1, {}, Vec3(-0.03, 0.0, 0.003) }, { "right", 1, {}, Vec3(0.04, 0.001, 0.0) } };
        for (VertexId v = 0; v < sheet.mesh.vertices.rows(); ++v) {
            const Vec3 p = sheet.mesh.vertices.row(v).transpose();
            if (p.z() < kRoundOff)
                sheet.supports.fixed.push_back(v);
            else if (p.z() > kTop - kRoundOff && p.y() > 5.0 && p.y() < 35.0)
                for (const std::size_t hook : { 0U, 1U })
                    if (const double from = hook == 0 ? 5.0 : 35.0; p.x() > from && p.x() < from + 20.0)
                        sheet.hooks[hook].nodes.push_back(v);
        }
        return sheet;
    }

    TEST(ErrorBars, NoneOnElementsTooFlatToTellBy)
    {
        for (const ElementKind element : { ElementKind::p2, ElementKind::locking_free }) {
            const bool ten_node = element == ElementKind::p2;
            const SolverSettings choice { .elasticity = fem::Elasticity::linear, .element = element };
            PlannedField field;
            field.problem = ten_node ? with_midpoints(flat_sheet()) : flat_sheet();
            field.hooks = field.problem.hooks;
            fem::Opening opening(
                field.problem.mesh, field.problem.material_of_label, field.problem.supports, opening_options(choice));
            field.opening = opening.open(field.hooks);
            ASSERT_EQ(field.opening.status, fem::OpeningStatus::converged) << field.opening.message;
            OpenedWound wound;
            const Points& u = field.opening.displacement;
            if (ten_node) { // as open_wall() leaves them: all nodes, and those of the wall
                wound.ten_node = Eigen::Map<const Eigen::VectorXd>(u.data(), u.size());
                field.opening.displacement.conservativeResize(flat_sheet().mesh.vertices.rows(), 3);
            }
            const ErrorBars bars = estimate_errors(field, wound, choice, [](const Points&) { return 0.0; }, {});
            EXPECT_NE(bars.message.find("too large or too flat for an error estimate"), std::string::npos)
                << to_string(element) << ": " << bars.message;
            EXPECT_TRUE(bars.hook_forces_N.empty());
        }
    }

    /// Where the share is a multiple of the opening's width, its bar is the same multiple of the width's bar: for held
    /// hooks, and for hooks that pull with a force, which move in the comparison solution.
    TEST(ErrorBars, TheShareSeenHasItsBarAsTheOpeningHas)
    {
        constexpr double kSharePerMm = 0.01, kRoundOff = 1e-12;
        const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
        Patient patient(test_support::block_case("share", phantom));
        for (const bool driven : { false, true })
            for (const ElementKind element : { ElementKind::p1, ElementKind::locking_free }) {
                const SolverSettings choice { .elasticity = fem::Elasticity::linear, .element = element };
                Case planned_case = patient.planned_case();
                planned_case.solution = choice;
                planned_case.accept_implausible = true;
                Patient same(planned_case);
                Approach approach = test_support::block_approach(*patient.labels(), Eigen::Isometry3d::Identity(), 6.0);
                if (driven)
                    for (HookSpec& hook : approach.hooks) {
                        hook.pull.force_N = 2.0;
                        hook.opening_mm = 0.0;
                    }
                PlannedField field = plan_approach(same, approach, {}, { .error_bars = false });
                ASSERT_EQ(field.status, PlanStatus::done) << field.message;
                const mesh::SweptBlade blade(blade_of(field.approach));
                const WoundEdges edges = wound_edges(field.wall, field.lips, blade);
                int calls = 0;
                const SeenShare share_of_width = [&](const Points& displacement) {
                    ++calls;
                    return kSharePerMm * opening_geometry(edges, field.wall, displacement).width_mm;
                };
                field.best_eye.seen_fraction = kSharePerMm * field.geometry.width_mm;
                const ErrorBars bars = estimate_errors(field, {}, choice, share_of_width, {});
                ASSERT_EQ(bars.message, "");
                EXPECT_GT(bars.opening_width_mm, 0.0);
                EXPECT_NEAR(bars.seen_best_eye, kSharePerMm * bars.opening_width_mm, kRoundOff);
                EXPECT_EQ(calls, (driven ? 2 : 1) + (element == ElementKind::locking_free ? 1 : 0));
            }
    }

    /// A retractor that four-node elements balance in another direction pushes as it does in the plan's direction.
    TEST(ErrorBars, ForcesOfARetractorAreComparedInItsOwnDirections)
    {
        constexpr double kRoundOff = 1e-9; // N
        const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
        Case planned_case = Patient(test_support::block_case("turned", phantom)).planned_case();
        const SolverSettings choice { .elasticity = fem::Elasticity::linear, .element = ElementKind::p2 };
        planned_case.solution = choice;
        planned_case.accept_implausible = true;
        Patient patient(planned_case);
        const Approach approach = test_support::block_approach(*patient.labels(), Eigen::Isometry3d::Identity(), 6.0);
        const PlannedField field = plan_approach(patient, approach, {}, { .error_bars = false });
        ASSERT_EQ(field.status, PlanStatus::done) << field.message;
        const auto solved = [&](const fem::ElasticProblem& problem) {
            return fem::Opening(problem, opening_options(choice)).open(problem.hooks);
        };
        OpenedWound wound;
        const Points ten_node = solved(field.problem).displacement;
        wound.ten_node = Eigen::Map<const Eigen::VectorXd>(ten_node.data(), ten_node.size());
        wound.coarse = solved(fem::without_midpoints(field.problem));
        const auto force_bars = [&](const OpenedWound& of) {
            ErrorBars bars = estimate_errors(field, of, choice, [](const Points&) { return 0.0; }, {});
            EXPECT_EQ(bars.message, "");
            return bars.hook_forces_N;
        };
        const std::vector<double> as_is = force_bars(wound);
        const Mat3 turned = Eigen::AngleAxisd(0.2, Vec3(1.0, 2.0, 2.0).normalized()).matrix();
        for (Vec3& force : wound.coarse->hook_forces_N)
            force = turned.transpose() * force;
        const std::vector<double> askew = force_bars(wound);
        wound.coarse_turn = turned;
        const std::vector<double> turned_back = force_bars(wound);
        ASSERT_EQ(turned_back.size(), as_is.size());
        for (std::size_t h = 0; h < as_is.size(); ++h) {
            EXPECT_GT(as_is[h], 0.0);
            EXPECT_NEAR(turned_back[h], as_is[h], kRoundOff);
            EXPECT_GT(askew[h], 1.05 * as_is[h]);
        }
    }

} // namespace error_bars_test
} // namespace retractor::planner
