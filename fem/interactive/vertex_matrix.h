#pragma once
// Parts of the online stiffness as sparse matrices for factorisation: some vertices, with three unknowns each.

#include "fem/interactive/online_stiffness.h"
#include "fem/linear_algebra/sparse_cholesky.h"
#include "fem/linear_algebra/symmetric_pattern.h"

#include <functional>
#include <vector>

namespace retractor::fem {

struct SparseMatrix {
    SymmetricPattern pattern;
    std::vector<double> values;
};

using RowOf = std::function<const OnlineStiffness::Row&(VertexId)>;

/// The rows and columns of `vertices`. @param number per vertex id: place in `vertices`, or -1
SparseMatrix vertex_matrix(
    const RowOf& row, const std::vector<VertexId>& vertices, const std::function<std::int32_t(VertexId)>& number);

/// An order of elimination of all unknowns: the vertices before `kept_from` in an order that keeps the factor small,
/// then the other vertices in their given order.
std::vector<std::int32_t> condensing_order(const RowOf& row, const std::vector<VertexId>& vertices,
    const std::function<std::int32_t(VertexId)>& number, std::size_t kept_from, Ordering ordering);

} // namespace retractor::fem
