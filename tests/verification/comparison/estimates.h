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
/// Fills in a row. The value is the estimated error over the true error, which must be between 0.5 and 3. Where the
/// answer is right to 0.01 %, the estimate must instead stay below 0.03 % of the answer. The row's error refers to
/// this factor, with a bound of 1. The error is NaN for a row without an answer or with an estimate that is not a
/// number.
void judge_estimate(VerificationRow& row, const std::string& quantity, const JudgedEstimate& judged);

/// The part of estimate_problem() with plain, locking-free and ten-node elements on a pressed tube, a bent bar and a
/// cut sheet.
std::vector<VerificationRow> element_estimates(const VerificationOptions& options, const Job& job);

} // namespace retractor::verification
