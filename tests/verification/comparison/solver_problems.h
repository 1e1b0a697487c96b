#pragma once
// Solvers against each other: the fast paths of the window, the ladder of elements and laws.

#include "tests/verification/framework/problem.h"

namespace retractor::verification {

/// Answers that follow the knife and the hooks, compared with a solution of the whole problem.
VerificationProblem fast_paths_problem();
/// Solvers of one opened incision, compared with the finest answer.
VerificationProblem solver_ladder_problem();

} // namespace retractor::verification
