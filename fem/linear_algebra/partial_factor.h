#pragma once
// Factors the first unknowns of a symmetric matrix, or all, and condenses them onto the last unknowns. CHOLMOD would
// also factor the last unknowns, which costs more than all the rest where they are many, and would use one core. Only
// sparse_cholesky.cpp uses this header.

#include "fem/linear_algebra/supernodes.h"
#include "fem/linear_algebra/symmetric_pattern.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace retractor::fem {

struct PartialFactor {
    Eigen::MatrixXd trailing; ///< lower triangle: the term that the condensed first unknowns add among the last
    /// Position in the order of elimination at which the matrix is not positive definite; -1: none.
    Eigen::Index stopped_at = -1;
};
/// Multifrontal Cholesky factorisation (Duff, Reid 1983, doi 10.1145/356044.356047). Two halves of the tree use two
/// cores, and so do the large fronts above them, with the same bits as one core. Entries of the matrix among the last
/// unknowns are not read.
/// @param f the analysed factor
/// @param x values of the factor; the function writes the columns before `end`
/// @param place position in the order of elimination, per unknown
PartialFactor factor_before(const Supernodes& f, double* x, Eigen::Index end, const SymmetricPattern& pattern,
    const std::vector<std::int32_t>& place, const std::vector<double>& values);

} // namespace retractor::fem
