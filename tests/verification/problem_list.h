#pragma once
// All problems and extreme cases of the finite elements, in the order in which retractor-verify runs them.

#include "tests/verification/framework/problem.h"
#include "tests/verification/framework/stability.h"

#include <vector>

namespace retractor::verification {

/// Problems with known answers.
std::vector<VerificationProblem> verification_problems();

/// Solvers of one opened incision against the finest answer.
std::vector<VerificationProblem> ladder_problems();

/// Extreme cases of the finite elements.
std::vector<StabilityCase> stability_cases();

} // namespace retractor::verification
