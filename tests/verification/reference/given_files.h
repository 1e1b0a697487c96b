#pragma once
// Problems with answers that another program published, read from the files of that program.

#include "tests/verification/framework/problem.h"

namespace retractor::verification {

VerificationProblem calculix_problem();
VerificationProblem febio_problem();

} // namespace retractor::verification
