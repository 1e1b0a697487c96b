#pragma once
// Every problem and every extreme case of the finite elements, in the order in which retractor-verify runs them.

#include "tests/verification/framework/problem.h"
#include "tests/verification/framework/stability.h"

#include <vector>

namespace retractor::verification {

/// Problems with known answers, in the order of the list of reference problems.
std::vector<VerificationProblem> verification_problems();

/// Solvers of one opened incision against the finest answer.
std::vector<VerificationProblem> ladder_problems();

/// Extreme cases, in the order of the list of extreme cases.
std::vector<StabilityCase> stability_cases();

} // namespace retractor::verification
