#include "tests/verification/framework/stability.h"

#include "mesh/base/error.h"
#include "tests/verification/framework/condition.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

namespace retractor::verification {

std::string outcome_name(StabilityOutcome outcome)
{
    switch (outcome) {
    case StabilityOutcome::answered:
        return "answer";
    case StabilityOutcome::refused:
        return "refusal";
    case StabilityOutcome::misbehaved:
        return "MISBEHAVED";
    }
    return {};
}

std::string unconditioned_name(Unconditioned why)
{
    switch (why) {
    case Unconditioned::unsaid:
        return {};
    case Unconditioned::no_matrix:
        return "no matrix";
    case Unconditioned::no_factor:
        return "no factor";
    case Unconditioned::explicit_steps:
        return "explicit";
    }
    return {};
}

bool StabilityRow::passed() const
{
    if (std::find(allowed.begin(), allowed.end(), outcome) == allowed.end())
        return false;
    if (!std::isfinite(condition) && unconditioned == Unconditioned::unsaid)
        return false;
    // nothing was measured, or no bound is given
    if (outcome == StabilityOutcome::refused && (reason.empty() || std::isinf(bound)))
        return !reason.empty();
    return error <= bound; // false for NaN
}

StabilityRow attempt(std::string problem, std::string model, const std::function<void(StabilityRow&)>& f)
{
    StabilityRow row;
    row.problem = std::move(problem);
    row.model = std::move(model);
    row.outcome = StabilityOutcome::answered;
    const Stopwatch watch;
    try {
        f(row);
        if (row.outcome == StabilityOutcome::answered && (!std::isfinite(row.residual) || !std::isfinite(row.error)))
            row.outcome = StabilityOutcome::misbehaved;
    } catch (const Error& error) {
        if (dynamic_cast<const InputError*>(&error) != nullptr && row.unconditioned == Unconditioned::unsaid)
            row.unconditioned = Unconditioned::no_matrix;
        refuse(row, error.where().empty() ? error.what() : error.what() + (" [" + error.where() + "]"));
    } catch (const std::exception& error) {
        row.outcome = StabilityOutcome::misbehaved;
        row.reason = error.what();
    }
    row.seconds = watch.seconds() - row.condition_seconds;
    return row;
}

StabilityRow expect_answer_or_refusal(
    std::string problem, std::string model, const std::string& named, const std::function<void(StabilityRow&)>& f)
{
    StabilityRow row = attempt(std::move(problem), std::move(model), f);
    row.allowed = { StabilityOutcome::answered, StabilityOutcome::refused };
    if (row.outcome == StabilityOutcome::refused && row.reason.find(named) == std::string::npos) {
        row.outcome = StabilityOutcome::misbehaved;
        row.reason = "refused, but not for \"" + named + "\": " + row.reason;
    }
    return row;
}

StabilityRow expect_refusal(
    std::string problem, std::string model, const std::string& named, const std::function<void(StabilityRow&)>& f)
{
    StabilityRow row = expect_answer_or_refusal(std::move(problem), std::move(model), named, f);
    row.allowed = { StabilityOutcome::refused };
    return row;
}

void refuse(StabilityRow& row, std::string reason)
{
    row.outcome = StabilityOutcome::refused;
    row.reason = std::move(reason);
}

double residual_of(const fem::Equilibrium& equilibrium, const std::vector<std::uint8_t>& prescribed)
{
    double free = 0.0;
    for (std::size_t i = 0; i < prescribed.size(); ++i)
        if (prescribed[i] == 0)
            free = std::max(free, std::abs(equilibrium.forces[static_cast<Eigen::Index>(i)]));
    const double all = equilibrium.forces.cwiseAbs().maxCoeff();
    return all > 0.0 ? free / all : 0.0;
}

namespace {

    /// Adds the time during which this object lives to the time of the condition numbers, also after an exception.
    struct ConditionWatch {
        StabilityRow& row;
        Stopwatch watch {};
        ~ConditionWatch() { row.condition_seconds += watch.seconds(); }
    };

    void estimate_into(StabilityRow& row, const fem::BlockMatrix& K, const std::vector<std::uint8_t>& prescribed)
    {
        try {
            const ConditionEstimate estimate = estimate_condition(K, prescribed);
            row.condition = estimate.number;
            row.scaled_condition = estimate.scaled;
            row.unconditioned = Unconditioned::unsaid; // whatever reason the family gave before
        } catch (const SolverError&) {
            row.unconditioned = Unconditioned::no_factor;
        }
    }

} // namespace

void set_condition(StabilityRow& row, const fem::BlockMatrix& K, const std::vector<std::uint8_t>& prescribed)
{
    const ConditionWatch watch { row };
    estimate_into(row, K, prescribed);
}

void set_condition(
    StabilityRow& row, const fem::ElasticProblem& problem, fem::Elasticity elasticity, const Points& displacement)
{
    const ConditionWatch watch { row };
    fem::ElasticBody body = fem::tissue_body(problem.mesh, problem.material_of_label, { .elasticity = elasticity });
    if (!problem.supports.bedded.empty())
        fem::set_springs(body, problem.supports);
    Eigen::VectorXd u = Eigen::VectorXd::Zero(3 * problem.mesh.vertices.rows());
    if (displacement.size() > 0)
        u = Eigen::Map<const Eigen::VectorXd>(displacement.data(), displacement.size());
    estimate_into(row, body.stiffness(u, 0.0), fem::prescribe(problem.mesh, problem.supports, problem.hooks).flag);
}

std::vector<StabilityRow> run_stability(const std::vector<StabilityCase>& cases, const Job& job)
{
    std::vector<StabilityRow> rows;
    for (std::size_t i = 0; i < cases.size() && !job.cancelled(); ++i) {
        job.report(cases[i].name, static_cast<double>(i) / static_cast<double>(cases.size()));
        Job quiet = job; // the case is the stage, not the steps inside
        quiet.on_progress = nullptr;
        for (StabilityRow& row : cases[i].run(quiet))
            rows.push_back(std::move(row));
    }
    return rows;
}

} // namespace retractor::verification
