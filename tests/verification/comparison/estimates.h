#pragma once
// Is the error estimate as large as the error? Problems with known answers, the estimate beside what is really missing.

#include "tests/verification/framework/problem.h"

#include <cmath>
#include <string>
#include <vector>

namespace retractor::verification {

VerificationProblem estimate_problem();

/// A number of an answer, how far it is estimated to be off, and the right one.
struct JudgedEstimate {
    double answer = 0.0, estimate = 0.0, right = 0.0;
    double error = std::abs(right - answer); ///< of sizes of vectors: of the vector
};
/// Value: estimated over true error, which must be 0.5 to 3; where the answer is right to 0.01 %, the estimate must
/// stay below 0.03 % of it instead. The row's error is on the factor, its bound 1; that of a row which has no answer,
/// or is given an estimate that is no number, stays or becomes NaN.
void check_estimate(VerificationRow& row, const std::string& quantity, const JudgedEstimate& judged);

/// Part of that problem: plain, locking-free and ten-node elements on a pressed tube, a bent bar and a cut sheet.
std::vector<VerificationRow> element_estimates(const VerificationOptions& options, const Job& job);

} // namespace retractor::verification
