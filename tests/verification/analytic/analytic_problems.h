#pragma once
// Problems whose answer is given by a formula. Each source of this folder defines one or several problems.

#include "tests/verification/framework/problem.h"

namespace retractor::verification {

VerificationProblem patch_test_problem();
VerificationProblem null_space_problem();
VerificationProblem pressed_tube_problem();
VerificationProblem stretched_tube_problem();
VerificationProblem tube_limit_problem();
VerificationProblem fibre_tube_problem();
VerificationProblem homogeneous_problem();
VerificationProblem manufactured_problem();
VerificationProblem cook_problem();
VerificationProblem cantilever_problem();
VerificationProblem cardiac_beam_problem();
VerificationProblem penny_problem();
VerificationProblem indentation_problem();
VerificationProblem gape_problem();
VerificationProblem drawn_ball_problem();

} // namespace retractor::verification
