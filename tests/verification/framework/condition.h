#pragma once
// Condition number of a stiffness matrix: an estimate of the digits that a solve can lose.

#include "fem/linear_algebra/block_matrix.h"

#include <cstdint>
#include <vector>

namespace retractor::verification {

/// Condition numbers in the 2-norm: largest over smallest eigenvalue on the free unknowns. Power iteration with the
/// matrix and with its factor finds both eigenvalues. Each estimate approaches its value from below, to about a
/// percent.
struct ConditionEstimate {
    /// Of the stiffness itself. The number rises with the ratio of the moduli, although that ratio loses no digits.
    double number = 0.0;
    /// Of the stiffness scaled to a unit diagonal. This scaling is within a factor (entries per row) of the best
    /// diagonal scaling (van der Sluis 1969), and the round-off of Cholesky follows this number.
    double scaled = 0.0;
};

/// @param prescribed one flag per unknown, 1 = prescribed
/// @throws SolverError naming node and axis when the matrix is not positive definite on the free unknowns
ConditionEstimate estimate_condition(const fem::BlockMatrix& K, const std::vector<std::uint8_t>& prescribed);

} // namespace retractor::verification
