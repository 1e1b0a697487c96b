#pragma once
// Symmetric sparse matrix of 3 x 3 blocks, one row of blocks per mesh node. Only the lower triangle is stored. The
// pattern is made once per mesh; elements then add their stiffness directly to the values.

#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::fem {

/// Compressed rows of the lower triangle, diagonal included. Columns rise within a row, so the diagonal block is the
/// last block of its row.
struct BlockPattern {
    std::vector<std::int32_t> row_start; ///< offset of each row in `column`; node count + 1 entries
    std::vector<std::int32_t> column; ///< node of each block

    std::size_t block_count() const { return column.size(); }
    std::size_t row_count() const { return row_start.size() - 1; }
};

/// Sets of coupled nodes, in compressed form. A group holds the nodes of an element, or of a domain of several
/// elements.
struct NodeGroups {
    std::vector<std::int32_t> start { 0 }; ///< offset of each group in `node`; group count + 1 entries
    std::vector<VertexId> node;

    std::size_t count() const { return start.size() - 1; }
    std::span<const VertexId> nodes(std::size_t group) const
    {
        return { node.data() + start[group], static_cast<std::size_t>(start[group + 1] - start[group]) };
    }
};

/// The pattern in which nodes of the same group are coupled. Nodes that are in no group have empty rows.
BlockPattern block_pattern(std::size_t node_count, const NodeGroups& groups);
/// The pattern in which nodes of the same element are coupled.
BlockPattern block_pattern(const mesh::TetMesh& mesh);

/// For each group and pair of its nodes, the block that the pair adds to, encoded as in element_block_map(). The pairs
/// of group g begin after the pairs of all earlier groups.
std::vector<std::int32_t> group_block_map(const NodeGroups& groups, const BlockPattern& pattern);

/// For each element and pair of local nodes (a >= b, at index a (a + 1) / 2 + b), the block that the pair adds to. The
/// entry is ~block when the block must be added transposed, because the two nodes have the other order in the mesh.
std::vector<std::int32_t> element_block_map(const mesh::TetMesh& mesh, const BlockPattern& pattern);

struct BlockMatrix {
    BlockPattern pattern;
    std::vector<double> values; ///< nine per block, row by row

    /// y = A x. Vectors have three entries per node.
    Eigen::VectorXd multiply(const Eigen::VectorXd& x) const;
};

} // namespace retractor::fem
