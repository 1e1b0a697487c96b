#include "planner/plan/accurate_plan.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/measures/metrics.h"
#include "planner/plan/plan_forecast.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace retractor::planner {

namespace {

    /// A smaller force is none: no hook is asked for less (planner/case/plausible_input.cpp).
    constexpr double kLeastForceN = 0.01;

    bool is_force_judged(const FieldMetrics& field)
    {
        const bool driven_by_force = field.retractor && field.retractor->asked_force_N;
        return !driven_by_force && !forces_are_known(field) && field.hook_force_N >= kLeastForceN;
    }

    /// The number by which answers are compared; the smaller is the better.
    double rank_of(const FieldMetrics& field)
    {
        const ReachedAccuracy reached = reached_accuracy(field);
        constexpr double kWithoutBars = std::numeric_limits<double>::infinity();
        return is_force_judged(field) ? reached.force.value_or(kWithoutBars)
                                      : reached.opening_mm.value_or(kWithoutBars);
    }

    class Search {
    public:
        Search(const AccuracySearch& asked, const PlanRound& plan)
            : asked_(asked)
            , plan_(plan)
        {
        }

        PlannedField run()
        {
            best_ = plan_(1.0);
            last_round_s_ = asked_.elapsed_s();
            if (!is_measured())
                return std::move(best_);
            accuracy_ = { .asked = asked_.goal, .edge_mm = best_.approach.sizing.corridor_edge_mm };
            last_tets_ = static_cast<double>(best_.metrics.tets);
            if (best_.status != PlanStatus::done)
                end(AccuracyEnd::failure,
                    best_.status == PlanStatus::inverted ? "elements of the first mesh are inside out"
                                                         : "the wound did not open as far as asked on the first mesh");
            while (!ended_ && !met_or_at_limit())
                try_finer();
            const ReachedAccuracy reached = reached_accuracy(best_.metrics);
            accuracy_.reached_force = reached.force;
            accuracy_.reached_opening_mm = reached.opening_mm;
            if (best_.status != PlanStatus::cancelled)
                best_.metrics.accuracy = std::move(accuracy_);
            return std::move(best_);
        }

    private:
        bool is_measured() const
        {
            return best_.status == PlanStatus::done || best_.status == PlanStatus::not_converged
                || best_.status == PlanStatus::inverted;
        }

        void end(AccuracyEnd by, std::string message = {})
        {
            ended_ = true;
            accuracy_.ended_by = by;
            accuracy_.message = std::move(message);
        }

        /// Ends the search when the goal is met, or when a limit forbids the next mesh.
        bool met_or_at_limit()
        {
            // The number of tetrahedra grows with the cube of what the edges shrink by.
            const double next_tets = last_tets_ / std::pow(kEdgeRefinement, 3);
            const PlanForecast last = forecast_plan(last_tets_, asked_.element);
            const PlanForecast next = forecast_plan(next_tets, asked_.element);
            // The last mesh tells how fast this machine is.
            const double next_s = last.seconds > 0.0 ? last_round_s_ * next.seconds / last.seconds : next.seconds;
            if (meets(reached_accuracy(best_.metrics), asked_.goal))
                end(AccuracyEnd::reached);
            else if (accuracy_.rounds >= kMostAccuracyRounds)
                end(AccuracyEnd::rounds);
            else if (asked_.elapsed_s() + next_s > asked_.goal.time_s)
                end(AccuracyEnd::time);
            else if (asked_.memory_bytes && next.bytes > *asked_.memory_bytes)
                end(AccuracyEnd::memory);
            return ended_;
        }

        void try_finer()
        {
            const double factor = std::pow(kEdgeRefinement, accuracy_.rounds);
            const double begin_s = asked_.elapsed_s();
            try {
                take(plan_(factor));
            } catch (const MemoryRefusal&) { // the mesh has more elements than twice the last one's
                end(AccuracyEnd::memory);
            } catch (const InputError& error) { // the first mesh passed with the same settings
                end(AccuracyEnd::failure, failure_text(error.what()));
            } catch (const SolverError& error) {
                end(AccuracyEnd::failure, failure_text(error.what()));
            }
            last_round_s_ = asked_.elapsed_s() - begin_s;
        }

        void take(PlannedField finer)
        {
            if (finer.status == PlanStatus::cancelled) {
                best_ = std::move(finer);
                ended_ = true;
                return;
            }
            if (finer.status != PlanStatus::done) {
                end(AccuracyEnd::failure, failure_text(finer.message));
                return;
            }
            ++accuracy_.rounds;
            accuracy_.edge_mm = finer.approach.sizing.corridor_edge_mm;
            last_tets_ = static_cast<double>(finer.metrics.tets);
            if (rank_of(finer.metrics) < rank_of(best_.metrics) || meets(reached_accuracy(finer.metrics), asked_.goal))
                best_ = std::move(finer);
        }

        static std::string failure_text(const std::string& reason)
        {
            return "the next finer mesh gave no answer" + (reason.empty() ? std::string() : ": " + reason);
        }

        const AccuracySearch& asked_;
        const PlanRound& plan_;
        PlannedField best_;
        AccuracyMetrics accuracy_;
        double last_tets_ = 0.0; ///< of the finest mesh that gave an answer
        double last_round_s_ = 0.0;
        bool ended_ = false;
    };

} // namespace

ReachedAccuracy reached_accuracy(const FieldMetrics& field)
{
    if (!field.error || !field.error->message.empty())
        return {};
    ReachedAccuracy reached { .opening_mm = field.error->opening_width_mm };
    if (is_force_judged(field))
        reached.force = field.error->hook_force_N / field.hook_force_N;
    return reached;
}

bool meets(const ReachedAccuracy& reached, const AccuracyGoal& goal)
{
    return reached.opening_mm && *reached.opening_mm <= goal.opening_mm
        && (!reached.force || *reached.force <= goal.force);
}

PlannedField plan_to_accuracy(const AccuracySearch& search, const PlanRound& plan)
{
    RETRACTOR_ASSERT(search.elapsed_s && plan);
    return Search(search, plan).run();
}

} // namespace retractor::planner
