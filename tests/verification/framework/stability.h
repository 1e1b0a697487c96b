#pragma once
// Stiff and extreme cases for `retractor-verify --suite stability`. Each case must end in an answer with its residual
// and error, or in a refusal with a reason; never in NaN, silence or a hang. Units mm, N, MPa, s.

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
    refused, ///< an error with a message and a place, or a status that names what was not reached
    misbehaved, ///< NaN, an exception that is not an Error of this program, or an outcome without an explanation
};
/// The name of an outcome: "answer", "refusal" or "MISBEHAVED".
std::string outcome_name(StabilityOutcome outcome);

/// Why a row has no condition numbers.
enum class Unconditioned {
    unsaid, ///< no reason given: the row fails
    no_matrix, ///< refused before a stiffness was assembled, or the solver has no matrix
    no_factor, ///< the stiffness is not positive definite: a piece is loose, or an element is inverted
    explicit_steps, ///< no system is solved, so round-off does not depend on a condition number
};
/// The name of a reason: "no matrix", "no factor" or "explicit"; empty for unsaid.
std::string unconditioned_name(Unconditioned why);

struct StabilityRow {
    std::string problem; ///< name of the case: "Poisson's ratio 0.4999"
    std::string model; ///< element and law, or the part of the program under test
    StabilityOutcome outcome = StabilityOutcome::misbehaved;
    std::vector<StabilityOutcome> allowed { StabilityOutcome::answered }; ///< outcomes that pass
    std::string quantity; ///< quantity of `error`
    std::string reason; ///< reason of a refusal, or a remark on an answer
    double residual = std::numeric_limits<double>::quiet_NaN(); ///< relative residual of the solver
    double error = std::numeric_limits<double>::quiet_NaN(); ///< error against the right answer
    double bound = std::numeric_limits<double>::infinity(); ///< largest error that passes, also for a refusal
    /// condition number (condition.h); NaN: none, for the reason `unconditioned`
    double condition = std::numeric_limits<double>::quiet_NaN();
    double scaled_condition = std::numeric_limits<double>::quiet_NaN();
    Unconditioned unconditioned = Unconditioned::unsaid;
    double seconds = 0.0; ///< run time without condition_seconds
    double condition_seconds = 0.0; ///< run time of the condition numbers

    bool passed() const;
};

struct StabilityCase {
    std::string name, about; ///< about: the required outcome
    std::function<std::vector<StabilityRow>(const Job&)> run;
};

/// Runs the cases one after the other.
/// @return all rows; fewer when the job was cancelled.
std::vector<StabilityRow> run_stability(const std::vector<StabilityCase>& cases, const Job& job);

// Tools for the families of cases.

/// Runs `f`, which fills in the row as an answer. An Error from `f` becomes a refusal; an InputError in a row without
/// a condition number becomes a refusal without a matrix. Any other exception, and a residual or error that is not
/// finite, is misbehaviour.
StabilityRow attempt(std::string problem, std::string model, const std::function<void(StabilityRow&)>& f);
/// As attempt(), where a refusal is required and its reason must contain `named`. Any other refusal is misbehaviour.
StabilityRow expect_refusal(
    std::string problem, std::string model, const std::string& named, const std::function<void(StabilityRow&)>& f);
/// As expect_refusal(), where an answer passes as well.
StabilityRow expect_answer_or_refusal(
    std::string problem, std::string model, const std::string& named, const std::function<void(StabilityRow&)>& f);
/// Thrown when the program breaks a guarantee that holds for every input (a sound mesh, an exact undo). The row then
/// counts as misbehaviour, so that no error passes as a refusal.
class PromiseNotKept : public std::logic_error {
public:
    using std::logic_error::logic_error;
};
/// Turns the row into a refusal by a status.
void refuse(StabilityRow& row, std::string reason);
/// Largest unbalanced force at a free unknown over the largest force anywhere. Unlike Equilibrium::residual, the
/// result is not rounded to zero at round-off.
double residual_of(const fem::Equilibrium& equilibrium, const std::vector<std::uint8_t>& prescribed);
/// Sets the condition numbers of a stiffness; none where the stiffness has no factor.
void set_condition(StabilityRow& row, const fem::BlockMatrix& K, const std::vector<std::uint8_t>& prescribed);
/// Sets the condition numbers of the stiffness at a displacement (n x 3, mm; empty: at rest) with supports and hooks
/// held.
void set_condition(
    StabilityRow& row, const fem::ElasticProblem& problem, fem::Elasticity elasticity, const Points& displacement = {});

} // namespace retractor::verification
