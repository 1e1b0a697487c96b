#pragma once
// Sparse matrices written out.

#include "fem/linear_algebra/block_matrix.h"

namespace retractor::test_support {

/// The full matrix with both triangles, for small matrices.
inline Eigen::MatrixXd dense(const fem::BlockMatrix& matrix)
{
    const auto n = static_cast<Eigen::Index>(3 * matrix.pattern.row_count());
    Eigen::MatrixXd full(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
        full.col(i) = matrix.multiply(Eigen::VectorXd::Unit(n, i));
    return full;
}

} // namespace retractor::test_support
