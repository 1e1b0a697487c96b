#pragma once
// Symmetric sparse matrix of 3 x 3 blocks, one row of blocks per mesh node; only its lower triangle is stored. The
// pattern is made once per mesh; elements then add straight into the values.

#include "mesh/tet_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace retractor {

/// Compressed rows of the lower triangle, diagonal included; columns rise within a row, so the diagonal block is last.
struct BlockPattern {
    std::vector<std::int32_t> row_start; ///< node count + 1
    std::vector<std::int32_t> column; ///< node

    std::size_t block_count() const { return column.size(); }
    std::size_t row_count() const { return row_start.size() - 1; }
};

/// Nodes of one element are coupled. Nodes that no element uses have empty rows.
BlockPattern block_pattern(const TetMesh& mesh);

/// Per element and pair of local nodes (a >= b, at a (a + 1) / 2 + b): the block they add to; ~block when the block is
/// to be added transposed (the global order of the two nodes is the other way round).
std::vector<std::int32_t> element_block_map(const TetMesh& mesh, const BlockPattern& pattern);

struct BlockMatrix {
    BlockPattern pattern;
    std::vector<double> values; ///< nine per block, row by row

    /// y = A x for vectors of three entries per node.
    Eigen::VectorXd multiply(const Eigen::VectorXd& x) const;
};

} // namespace retractor
