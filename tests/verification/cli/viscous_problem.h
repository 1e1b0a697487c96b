#pragma once
// Creep and relaxation of one viscous element of the spring tissue (spring_motion.h), compared with its closed form
// at three time steps. Units mm, N, s, tonne.

#include "tests/verification/framework/problem.h"

namespace retractor::verification {

/// In the rows `size` is the time step relative to the coarsest, and `nodes` counts particles; there are no
/// tetrahedra.
VerificationProblem viscous_problem();

} // namespace retractor::verification
