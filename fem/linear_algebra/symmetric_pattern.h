#pragma once
// Where a sparse symmetric matrix has entries: shared by its assembly, its factorisation and its condensation.

#include <cstdint>
#include <vector>

namespace retractor::fem {

/// One triangle of a symmetric matrix: compressed columns of the upper triangle, diagonal included, rows rising.
struct SymmetricPattern {
    std::vector<std::int32_t> column_start; ///< n + 1
    std::vector<std::int32_t> row;

    std::int32_t size() const { return static_cast<std::int32_t>(column_start.size()) - 1; }
};

} // namespace retractor::fem
