#pragma once
// Is the error estimate as large as the error? Problems with known answers, the estimate beside what is really missing.

#include "fem/verification/problem.h"

namespace retractor {

VerificationProblem estimate_problem();

} // namespace retractor
