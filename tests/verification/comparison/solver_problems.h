#pragma once
// Comparisons of solvers: the fast paths of the window, the ladder of elements and laws, and parts of a body.

#include "tests/verification/framework/problem.h"

namespace retractor::verification {

/// Answers that follow the knife and the hooks, compared with a solution of the whole problem.
VerificationProblem fast_paths_problem();
/// Solvers of one opened incision, compared with the finest answer.
VerificationProblem solver_ladder_problem();
/// Parts of a body, compared with the whole body.
VerificationProblem localisation_problem();

} // namespace retractor::verification
