#pragma once
// The pattern of a sparse symmetric matrix, shared by its assembly, its factorisation and its condensation.

#include <cstdint>
#include <vector>

namespace retractor::fem {

/// One triangle of a symmetric matrix: compressed columns of the upper triangle, diagonal included, with rising rows.
struct SymmetricPattern {
    std::vector<std::int32_t> column_start; ///< offset of each column in `row`; n + 1 entries
    std::vector<std::int32_t> row;

    std::int32_t size() const { return static_cast<std::int32_t>(column_start.size()) - 1; }
};

} // namespace retractor::fem
