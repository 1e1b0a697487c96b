#pragma once
// How well a stiffness is conditioned: how much of the sixteen digits a solve can lose.

#include "fem/linear_algebra/block_matrix.h"

#include <cstdint>
#include <vector>

namespace retractor::verification {

/// Condition numbers in the 2-norm, largest over smallest eigenvalue on the free unknowns, by power iteration with the
/// matrix and with its factor. Each is approached from below, to about a percent.
struct ConditionEstimate {
    double number = 0.0; ///< of the stiffness itself; grows with the ratio of the moduli though nothing is lost by it
    /// Of the stiffness scaled to a unit diagonal, which is within a factor (entries per row) of the best scaling there
    /// is [van der Sluis 1969]: Cholesky's round-off follows this one.
    double scaled = 0.0;
};

/// @param prescribed one per unknown, 1 = prescribed.
/// @throws SolverError naming node and axis when the matrix is not positive definite on the free unknowns.
ConditionEstimate estimate_condition(const fem::BlockMatrix& K, const std::vector<std::uint8_t>& prescribed);

} // namespace retractor::verification
