#pragma once
// Compares error estimates with true errors on problems with known answers.

#include "tests/verification/framework/problem.h"

#include <cmath>
#include <string>
#include <vector>

namespace retractor::verification {

VerificationProblem estimate_problem();

/// A number of an answer, the estimate of its error, and the right number.
struct JudgedEstimate {
    double answer = 0.0, estimate = 0.0, right = 0.0;
    double error = std::abs(right - answer); ///< true error; for sizes of vectors the size of the error vector
};
/// Value: estimated over true error, which must be 0.5 to 3; where the answer is right to 0.01 %, the estimate must
/// stay below 0.03 % of it instead. The row's error is on the factor, its bound 1; that of a row which has no answer,
/// or is given an estimate that is no number, stays or becomes NaN.
void check_estimate(VerificationRow& row, const std::string& quantity, const JudgedEstimate& judged);

/// The part of estimate_problem() with plain, locking-free and ten-node elements on a pressed tube, a bent bar and a
/// cut sheet.
std::vector<VerificationRow> element_estimates(const VerificationOptions& options, const Job& job);

} // namespace retractor::verification
