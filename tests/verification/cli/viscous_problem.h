#pragma once
// Creep and relaxation of the elements that tissue of springs is made of (haptics/spring_motion.h), one element beside
// its closed form, at three time steps: what `retractor-verify` shows of time. Units mm, N, s, tonne.

#include "tests/verification/framework/problem.h"

namespace retractor::verification {

/// Rows: `size` is the time step over the coarsest, `nodes` are particles; there are no tetrahedra.
VerificationProblem viscous_problem();

} // namespace retractor::verification
