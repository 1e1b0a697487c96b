#pragma once
// Stiff and extreme cases: each must end in an answer, with its residual and its error, or in a refusal that says why;
// never in NaN, silence or a hang. What `retractor-verify --suite stability` runs. Units mm, N, MPa, s.

#include "fem/linear_algebra/block_matrix.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/equilibrium.h"
#include "mesh/base/job.h"

#include <Eigen/Core>

#include <cstdint>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace retractor::verification {

enum class StabilityOutcome {
    answered,
    refused, ///< an error with a message and a place, or a status that says what was not reached
    misbehaved, ///< NaN, an exception that is no Error of ours, or an outcome that nothing explains
};
/// "answer", "refusal", "MISBEHAVED".
std::string outcome_name(StabilityOutcome outcome);

/// Why a row has no condition numbers.
enum class Unconditioned {
    unsaid, ///< no reason: the row does not pass
    no_matrix, ///< refused before a stiffness was assembled, or there is none to solve with
    no_factor, ///< the stiffness is not positive definite: a piece is loose, an element turned over
    explicit_steps, ///< nothing is solved: round-off does not follow a condition number
};
/// "no matrix", "no factor", "explicit"; empty for unsaid.
std::string unconditioned_name(Unconditioned why);

struct StabilityRow {
    std::string problem; ///< the case: "Poisson's ratio 0.4999"
    std::string model; ///< element and law, or the part of the program that is asked
    StabilityOutcome outcome = StabilityOutcome::misbehaved;
    std::vector<StabilityOutcome> allowed { StabilityOutcome::answered }; ///< what the outcome must be one of
    std::string quantity; ///< what `error` is of
    std::string reason; ///< of a refusal; of an answer: what is to be said about it
    double residual = std::numeric_limits<double>::quiet_NaN(); ///< of the solver, relative
    double error = std::numeric_limits<double>::quiet_NaN(); ///< against what the answer must be
    double bound = std::numeric_limits<double>::infinity(); ///< that the error must stay below, of a refusal too
    double condition = std::numeric_limits<double>::quiet_NaN(); ///< condition.h; NaN: none, for this reason
    double scaled_condition = std::numeric_limits<double>::quiet_NaN();
    Unconditioned unconditioned = Unconditioned::unsaid;
    double seconds = 0.0; ///< without the next
    double condition_seconds = 0.0; ///< that the condition numbers took

    bool passed() const;
};

struct StabilityCase {
    std::string name, about; ///< about: what must happen
    std::function<std::vector<StabilityRow>(const Job&)> run;
};

/// Runs the cases one after the other. @return all rows; fewer when the job was cancelled.
std::vector<StabilityRow> run_stability(const std::vector<StabilityCase>& cases, const Job& job);

// For the families.

/// Runs `f`, which fills the row in as an answer; an Error that it throws becomes a refusal (an InputError one without
/// a matrix, where the row has no condition yet), everything else that it throws, a residual or an error that is not
/// finite is misbehaviour.
StabilityRow attempt(std::string problem, std::string model, const std::function<void(StabilityRow&)>& f);
/// The same where a refusal is what must come, and its reason must contain `named`: a refusal of something else is
/// misbehaviour.
StabilityRow expect_refusal(
    std::string problem, std::string model, const std::string& named, const std::function<void(StabilityRow&)>& f);
/// The same where an answer may come as well.
StabilityRow expect_answer_or_refusal(
    std::string problem, std::string model, const std::string& named, const std::function<void(StabilityRow&)>& f);
/// For what the program itself must keep, whatever it is asked (a sound mesh, an exact undo): thrown, it makes the row
/// misbehave, so that no error can pass for a refusal.
class PromiseNotKept : public std::logic_error {
public:
    using std::logic_error::logic_error;
};
/// Makes the row a refusal by a status.
void refuse(StabilityRow& row, std::string reason);
/// Largest force that is left at a free unknown over the largest force anywhere: not rounded to zero where it is
/// round-off, as Equilibrium::residual is.
double residual_of(const fem::Equilibrium& equilibrium, const std::vector<std::uint8_t>& prescribed);
/// Condition numbers of a stiffness; none where it has no factor.
void set_condition(StabilityRow& row, const fem::BlockMatrix& K, const std::vector<std::uint8_t>& prescribed);
/// Of the stiffness at a displacement (n x 3; empty: at rest), supports and hooks held.
void set_condition(
    StabilityRow& row, const fem::ElasticProblem& problem, fem::Elasticity elasticity, const Points& displacement = {});

} // namespace retractor::verification
