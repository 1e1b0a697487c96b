#pragma once
// The first unknowns of a symmetric matrix factored and condensed onto the last: CHOLMOD would go on to factor these as
// well, which costs more than all the rest where they are many. Only for sparse_cholesky.cpp.

#include "fem/linear_algebra/supernodes.h"
#include "fem/linear_algebra/symmetric_pattern.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace retractor::fem {

struct PartialFactor {
    Eigen::MatrixXd trailing; ///< lower triangle: what the first unknowns, condensed, add among the last
    Eigen::Index stopped_at
        = -1; ///< in the order of elimination, where the matrix is not positive definite; -1: nowhere
};
/// Multifrontal Cholesky [Duff and Reid 1983], subtrees on two cores, the same bits on one. Entries of the matrix among
/// the last unknowns are not read. @param f as analysed. @param x its numbers, written for the columns before `end`.
/// @param place per unknown: where it comes in the order of elimination.
PartialFactor factor_before(const Supernodes& f, double* x, Eigen::Index end, const SymmetricPattern& pattern,
    const std::vector<std::int32_t>& place, const std::vector<double>& values);

} // namespace retractor::fem
