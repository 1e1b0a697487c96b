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

    /// Answers by other elements, which the error of the field's is told by.
    struct OtherAnswers {
        std::string message {}; ///< why there are none; empty: there are
        HeldHooks held {}; ///< in one of them or in the field's own
        WoundAnswer other {};
        double factor = 1.0; ///< the error, over the difference from that
        /// Where ten-node elements are the other: plain four-node ones, and what ten-node ones lack over the
        /// difference from these.
        std::optional<WoundAnswer> plain {};
        double lacking = 0.0;
        std::optional<EnergyBars> energy {};
    };

    /// Why a share of ten_node_share() tells no error; empty: it does.
    std::string without_share(double share)
    {
        return share <= fem::kMostShare ? "" // not of what is no number either
                                        : "these elements are too large or too flat to tell how far ten-node "
                                          "ones are off; ask for a finer mesh";
    }

    /// What ten-node elements would say, to first order.
    OtherAnswers finer_answer(
        const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice, const Job& job)
    {
        const Points& solved = wound.rigid.vertices.empty() ? field.opening.displacement : wound.rigid.solved;
        fem::ErrorEstimate finer = fem::estimate_error(field.problem, choice.elasticity, solved, job, wound.contact);
        OtherAnswers answers { .message = finer.message };
        if (finer.status != fem::EstimateStatus::done) {
            if (has_condensed_region(field) && field.opening.inverted_elements > 0)
                answers.message += ", perhaps by the linear far field: nonlinear farther out they would not be";
            return answers;
        }
        const bool locking_free = choice.element == ElementKind::locking_free;
        answers.held = held_hooks(field.approach, field.problem, { choice.elasticity, locking_free }, solved,
            field.opening.hook_forces_N, wound.contact);
        answers.other = { std::move(finer.displacement), std::move(finer.hook_forces_N) };
        if (locking_free) {
            answers.lacking
                = fem::ten_node_share(with_midpoints(field.problem), choice.elasticity, finer.ten_node, finer.plain);
            answers.message = without_share(answers.lacking);
            answers.plain = WoundAnswer { std::move(finer.plain), std::move(finer.plain_forces_N) };
            return answers;
        }
        answers.factor = 1.0 / fem::kErrorShare;
        // Of the equations that were solved: not with a linear far field or a penalty.
        if (!has_condensed_region(field) && !wound.contact)
            answers.energy = EnergyBars { finer.energy_error / std::sqrt(fem::kErrorShare), finer.algebraic_error };
        return answers;
    }

    /// What plain elements say on the corners of ten-node ones: finer ones than these would take too long.
    OtherAnswers coarser_answer(
        const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice, const Job& job)
    {
        const fem::ElasticProblem coarse = fem::without_midpoints(field.problem);
        fem::OpeningOptions options { .elasticity = choice.elasticity };
        options.contact = wound.contact;
        if (has_condensed_region(field))
            options.near = near_elements(field, choice.near_mm);
        options.far_tolerance = std::numeric_limits<double>::infinity(); // it is linear there, as in the answer
        fem::Opening opening(coarse, options);
        fem::OpeningResult result = opening.open(coarse.hooks, as_stage(job, "opening, four-node elements"));
        if (!is_usable(result))
            return { .message = "the four-node answer to compare with: " + result.message };
        OtherAnswers answers;
        answers.factor = fem::ten_node_share(field.problem, choice.elasticity, wound.ten_node, result.displacement);
        answers.message = without_share(answers.factor);
        answers.held = held_hooks(
            field.approach, coarse, { choice.elasticity }, result.displacement, result.hook_forces_N, wound.contact);
        answers.other = { std::move(result.displacement), std::move(result.hook_forces_N) };
        return answers;
    }

    double moved_mm(const PlannedField& field, const WoundAnswer& answer, std::size_t hook)
    {
        return (answer.hooks_mm.empty() ? field.hooks[hook].displacement : answer.hooks_mm[hook]).norm();
    }

    void fill_bars(ErrorBars& bars, const PlannedField& field, const OpenedWound& wound, OtherAnswers answers)
    {
        const std::size_t hooks = field.hooks.size();
        // The opening changes one way with the hooks held, and the other way once they have moved: where the two
        // cancel, what each is not known to is left.
        const auto of_parts
            = [](double in_all, double held) { return std::max(in_all, (1.0 - fem::kErrorShare) * held); };
        const auto add = [&](WoundAnswer& a, WoundAnswer& b, const WoundMeasures& b_held, double factor) {
            const double of_opening = std::max(factor, fem::kLeastOpeningShare);
            const WoundMeasures of_a = measures_of(field, wound.rigid, a.displacement, a.hook_forces_N),
                                of_b = measures_of(field, wound.rigid, b.displacement, b.hook_forces_N);
            bars.opening_width_mm += of_opening
                * of_parts(std::abs(of_a.width_mm - of_b.width_mm), std::abs(of_a.width_mm - b_held.width_mm));
            bars.opening_area_mm2 += of_opening
                * of_parts(std::abs(of_a.area_mm2 - of_b.area_mm2), std::abs(of_a.area_mm2 - b_held.area_mm2));
            const std::vector<bool> pushing_in_a = pushing_hooks(field.approach, a.hook_forces_N),
                                    pushing_in_b = pushing_hooks(field.approach, b.hook_forces_N);
            for (std::size_t i = 0; i < hooks; ++i) {
                // The size of a force that is asked for, or is the limit, is known, its direction may not be. Of others
                // the size may agree where along and across they are off: errors of different signs cancel in it.
                const Vec3 &f = a.hook_forces_N[i], &g = b.hook_forces_N[i];
                const bool size_known
                    = field.approach.hooks[i].pull.force_N || (i < field.yielded.size() && field.yielded[i]);
                const double off = factor * (size_known ? std::abs(f.norm() - g.norm()) : (f - g).norm());
                bars.hook_forces_N[i] += off;
                bars.hook_moved_mm[i] += of_opening * std::abs(moved_mm(field, a, i) - moved_mm(field, b, i));
                if (!pushing_in_a[i] || !pushing_in_b[i]) // those that pull make up their side's force
                    bars.side_forces_N[field.hooks[i].side > 0 ? 0 : 1] += off;
            }
        };
        WoundAnswer own { field.opening.displacement, field.opening.hook_forces_N };
        const WoundMeasures held
            = measures_of(field, wound.rigid, answers.other.displacement, answers.other.hook_forces_N);
        if (!correct_hook_equilibrium(answers.held, answers.other)
            || (answers.plain && !correct_hook_equilibrium(answers.held, *answers.plain))) {
            bars.message = "the forces of other elements differ too far to tell where the hooks would rest; "
                           "ask for a finer mesh";
            return;
        }
        bars.hook_forces_N.assign(hooks, 0.0);
        RETRACTOR_ASSERT(answers.other.hook_forces_N.size() == hooks && own.hook_forces_N.size() == hooks);
        bars.hook_moved_mm.assign(hooks, 0.0);
        add(own, answers.other, held, answers.factor);
        if (answers.plain)
            add(*answers.plain, answers.other,
                measures_of(field, wound.rigid, answers.other.displacement, answers.other.hook_forces_N),
                answers.lacking);
        bars.hook_force_N = std::max(bars.side_forces_N[0], bars.side_forces_N[1]);
        bars.energy = answers.energy;
    }

} // namespace

ErrorBars estimate_errors(
    const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice, const Job& job)
{
    ErrorBars bars;
    if (!is_usable(field.opening)) {
        bars.message = field.opening.status == fem::OpeningStatus::inverted
            ? "elements of the opened wound are inside out"
            : "the wound was not opened as asked";
        return bars;
    }
    const Stopwatch watch;
    try {
        OtherAnswers answers = choice.element == ElementKind::p2 ? coarser_answer(field, wound, choice, job)
                                                                 : finer_answer(field, wound, choice, job);
        bars.message = answers.message;
        if (bars.message.empty())
            fill_bars(bars, field, wound, std::move(answers));
    } catch (const Error& error) {
        bars.message = error.what();
    }
    bars.seconds = watch.seconds();
    return bars;
}

} // namespace retractor::planner
