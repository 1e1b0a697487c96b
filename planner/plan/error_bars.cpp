#include "planner/plan/error_bars.h"

#include "fem/error_estimation/error_estimate.h"
#include "fem/statics/opening.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "planner/plan/hook_equilibrium_correction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

namespace retractor::planner {

namespace {

    /// Solutions by other elements, from which the error of the field's solution is estimated.
    struct ComparisonSolutions {
        std::string message {}; ///< reason for missing solutions; empty: the solutions are there
        HeldHooks held {}; ///< fixed hooks of one of these solutions or of the field's own
        WoundSolution other {};
        double factor = 1.0; ///< ratio of the error to the difference between field and `other`
        /// Solution by plain four-node elements, when `other` is by ten-node elements and the field's elements are
        /// locking-free.
        std::optional<WoundSolution> plain {};
        double lacking = 0.0; ///< ratio of the error of `other` to the difference between `plain` and `other`
        std::optional<EnergyBars> energy {};
    };

    /// Why a result of ten_node_share() gives no estimate; empty: the result does.
    /// @param most kMostShare or kMostShareOfMixed
    std::string without_share(double share, double most)
    {
        return share <= most ? "" // the comparison also refuses NaN
                             : "the elements are too large or too flat for an error estimate of ten-node elements; "
                               "use a finer mesh";
    }

    /// Whether some elements have fewer than ten nodes.
    bool has_straight_edges(const mesh::TetMesh& mesh)
    {
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
                if (mesh::is_straight(mesh.tet(t), e))
                    return true;
        return false;
    }

    /// The displacement of the wall's vertices, without the nodes of blades, which follow them.
    Points of_vertices(const PlannedField& field, const Points& displacement)
    {
        return displacement.topRows(field.wall.vertices.rows());
    }

    /// The first-order solution by ten-node elements.
    ComparisonSolutions finer_solution(
        const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice, const Job& job)
    {
        const Points solved = fem::with_blade_nodes(
            field.problem, wound.rigid.vertices.empty() ? field.opening.displacement : wound.rigid.solved);
        fem::ErrorEstimate finer = fem::estimate_error(field.problem, choice.elasticity, solved, job, wound.contact);
        ComparisonSolutions solutions { .message = finer.message };
        if (finer.status != fem::EstimateStatus::done) {
            if (has_condensed_region(field) && field.opening.inverted_elements > 0)
                solutions.message += "; a larger nonlinear region (near_mm) may prevent the inverted elements";
            return solutions;
        }
        const bool locking_free = choice.element == ElementKind::locking_free;
        solutions.held = held_hooks(field.approach, field.problem, { choice.elasticity, locking_free }, solved,
            field.opening.hook_forces_N, wound.contact);
        solutions.other = { of_vertices(field, finer.displacement), std::move(finer.hook_forces_N) };
        if (locking_free) {
            solutions.lacking
                = fem::ten_node_share(with_midpoints(field.problem), choice.elasticity, finer.ten_node, finer.plain);
            solutions.message = without_share(solutions.lacking, fem::kMostShare);
            solutions.plain = WoundSolution { of_vertices(field, finer.plain), std::move(finer.plain_forces_N) };
            return solutions;
        }
        solutions.factor = 1.0 / fem::kErrorShare;
        // A linear condensed region and contact change the equations, so that the energy error is unknown.
        if (!has_condensed_region(field) && !wound.contact)
            solutions.energy = EnergyBars { finer.energy_error / std::sqrt(fem::kErrorShare), finer.algebraic_error };
        return solutions;
    }

    /// The solution by plain four-node elements on the corners of ten-node elements. Elements finer than ten-node
    /// elements would take too long.
    ComparisonSolutions coarser_solution(
        const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice, const Job& job)
    {
        const fem::ElasticProblem coarse = fem::without_midpoints(field.problem);
        const auto open_coarse = [&] {
            fem::OpeningOptions options { .elasticity = choice.elasticity };
            options.contact = wound.contact;
            if (has_condensed_region(field))
                options.near = near_elements(field, choice.near_mm);
            options.far_tolerance = std::numeric_limits<double>::infinity(); // the region stays linear, as in the field
            const Job named = as_stage(job, "opening, four-node elements");
            if (!has_condensed_region(field)) { // the field's own solution is near
                fem::Opening opening(coarse, options);
                opening.start_from(fem::with_blade_nodes(
                    coarse, wound.rigid.vertices.empty() ? field.opening.displacement : wound.rigid.solved));
                fem::OpeningResult result = opening.open(coarse.hooks, named);
                if (is_usable(result) || result.status == fem::OpeningStatus::cancelled)
                    return result;
            }
            return fem::Opening(coarse, options).open(coarse.hooks, named);
        };
        fem::OpeningResult result = wound.coarse ? *wound.coarse : open_coarse();
        if (wound.coarse) // forces of a retractor in the directions of its own frame
            for (Vec3& force : result.hook_forces_N)
                force = wound.coarse_turn * force;
        if (!is_usable(result))
            return { .message = "the solution by four-node elements failed: " + result.message };
        ComparisonSolutions solutions;
        solutions.factor = fem::ten_node_share(field.problem, choice.elasticity, wound.ten_node, result.displacement);
        solutions.message = without_share(
            solutions.factor, has_straight_edges(field.problem.mesh) ? fem::kMostShareOfMixed : fem::kMostShare);
        solutions.held = held_hooks(
            field.approach, coarse, { choice.elasticity }, result.displacement, result.hook_forces_N, wound.contact);
        solutions.other = { of_vertices(field, result.displacement), std::move(result.hook_forces_N) };
        return solutions;
    }

    double moved_mm(const PlannedField& field, const WoundSolution& solution, std::size_t hook)
    {
        return (solution.hooks_mm.empty() ? field.hooks[hook].displacement : solution.hooks_mm[hook]).norm();
    }

    /// The numbers that a solution gives the opened wound.
    struct OpeningNumbers {
        double width_mm = 0.0, area_mm2 = 0.0, seen = 0.0;
    };

    /// Measures a comparison solution. The function moves the rigid pieces in its displacement.
    OpeningNumbers numbers_of(
        const PlannedField& field, const RigidPieces& rigid, WoundSolution& solution, const SeenShare& seen_share)
    {
        const WoundMeasures measures = measures_of(field, rigid, solution.displacement, solution.hook_forces_N);
        return { measures.width_mm, measures.area_mm2, seen_share(solution.displacement) };
    }

    /// The part of a bar that two numbers of a solution and the number of the same solution with fixed hooks give.
    /// Fixed hooks change the opening in one direction, and the motion of the hooks changes the opening in the other.
    /// Where both changes cancel, the uncertainty of each change remains.
    double bar_of_opening(double a, double b, double b_held)
    {
        return std::max(std::abs(a - b), (1.0 - fem::kErrorShare) * std::abs(a - b_held));
    }

    void add_opening(
        ErrorBars& bars, double factor, const OpeningNumbers& a, const OpeningNumbers& b, const OpeningNumbers& b_held)
    {
        bars.opening_width_mm += factor * bar_of_opening(a.width_mm, b.width_mm, b_held.width_mm);
        bars.opening_area_mm2 += factor * bar_of_opening(a.area_mm2, b.area_mm2, b_held.area_mm2);
        bars.seen_best_eye += factor * bar_of_opening(a.seen, b.seen, b_held.seen);
    }

    void add_hooks(
        ErrorBars& bars, const PlannedField& field, const WoundSolution& a, const WoundSolution& b, double factor)
    {
        RETRACTOR_ASSERT(a.hook_forces_N.size() == field.hooks.size() && b.hook_forces_N.size() == field.hooks.size());
        const double of_opening = std::max(factor, fem::kLeastOpeningShare);
        const std::vector<bool> pushing_in_a = pushing_hooks(field.approach, a.hook_forces_N),
                                pushing_in_b = pushing_hooks(field.approach, b.hook_forces_N);
        for (std::size_t i = 0; i < field.hooks.size(); ++i) {
            // The magnitude of a prescribed force or of a force at its limit is known; the direction may change.
            // For other hooks the vectors are compared: errors of different signs may cancel in the magnitude.
            const Vec3 &f = a.hook_forces_N[i], &g = b.hook_forces_N[i];
            const bool size_known
                = field.approach.hooks[i].pull.force_N || (i < field.yielded.size() && field.yielded[i]);
            const double off = factor * (size_known ? std::abs(f.norm() - g.norm()) : (f - g).norm());
            bars.hook_forces_N[i] += off;
            bars.hook_moved_mm[i] += of_opening * std::abs(moved_mm(field, a, i) - moved_mm(field, b, i));
            if (!pushing_in_a[i] || !pushing_in_b[i]) // only hooks that pull count in their side's sum
                bars.side_forces_N[field.hooks[i].side > 0 ? 0 : 1] += off;
        }
    }

    void fill_bars(ErrorBars& bars, const PlannedField& field, const OpenedWound& wound, ComparisonSolutions solutions,
        const SeenShare& seen_share)
    {
        const auto numbers
            = [&](WoundSolution& solution) { return numbers_of(field, wound.rigid, solution, seen_share); };
        const WoundSolution own { field.opening.displacement, field.opening.hook_forces_N };
        const OpeningNumbers of_own { field.geometry.width_mm, field.geometry.area_mm2, field.best_eye.seen_fraction };
        const OpeningNumbers held = numbers(solutions.other);
        if (!correct_hook_equilibrium(solutions.held, solutions.other)
            || (solutions.plain && !correct_hook_equilibrium(solutions.held, *solutions.plain))) {
            bars.message = "the hook forces by other elements differ too much to predict the equilibrium of the hooks; "
                           "use a finer mesh";
            return;
        }
        const OpeningNumbers of_other = solutions.held.drives.empty() ? held : numbers(solutions.other);
        bars.hook_forces_N.assign(field.hooks.size(), 0.0);
        bars.hook_moved_mm.assign(field.hooks.size(), 0.0);
        add_opening(bars, std::max(solutions.factor, fem::kLeastOpeningShare), of_own, of_other, held);
        add_hooks(bars, field, own, solutions.other, solutions.factor);
        if (solutions.plain) {
            add_opening(bars, std::max(solutions.lacking, fem::kLeastOpeningShare), numbers(*solutions.plain), of_other,
                of_other);
            add_hooks(bars, field, *solutions.plain, solutions.other, solutions.lacking);
        }
        for (double& bar : bars.hook_forces_N)
            bar += field.opening.stiffening_changed_N;
        for (double& bar : bars.side_forces_N)
            bar += field.opening.stiffening_changed_N;
        bars.opening_width_mm += field.opening.stiffening_changed_mm;
        for (double& bar : bars.hook_moved_mm)
            bar += 0.5 * field.opening.stiffening_changed_mm; // each blade moves half of the distance
        bars.hook_force_N = std::max(bars.side_forces_N[0], bars.side_forces_N[1]);
        bars.energy = solutions.energy;
    }

} // namespace

ErrorBars estimate_errors(const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice,
    const SeenShare& seen_share, const Job& job)
{
    ErrorBars bars;
    if (!is_usable(field.opening)) {
        bars.message = field.opening.status == fem::OpeningStatus::inverted
            ? "elements of the opened wound are inside out"
            : "the wound did not open as requested";
        return bars;
    }
    const Stopwatch watch;
    try {
        ComparisonSolutions solutions = has_ten_nodes(choice.element) ? coarser_solution(field, wound, choice, job)
                                                                      : finer_solution(field, wound, choice, job);
        bars.message = solutions.message;
        if (bars.message.empty())
            fill_bars(bars, field, wound, std::move(solutions), seen_share);
    } catch (const Error& error) {
        bars.message = error.what();
    }
    bars.seconds = watch.seconds();
    return bars;
}

} // namespace retractor::planner
