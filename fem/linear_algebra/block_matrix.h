#pragma once
// Symmetric sparse matrix of 3 x 3 blocks, one row of blocks per mesh node; only its lower triangle is stored. The
// pattern is made once per mesh; elements then add straight into the values.

#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::fem {

/// Compressed rows of the lower triangle, diagonal included; columns rise within a row, so the diagonal block is last.
struct BlockPattern {
    std::vector<std::int32_t> row_start; ///< node count + 1
    std::vector<std::int32_t> column; ///< node

    std::size_t block_count() const { return column.size(); }
    std::size_t row_count() const { return row_start.size() - 1; }
};

/// Sets of nodes that are coupled, compressed: those of an element, or of a domain that spans several.
struct NodeGroups {
    std::vector<std::int32_t> start { 0 }; ///< group count + 1
    std::vector<VertexId> node;

    std::size_t count() const { return start.size() - 1; }
    std::span<const VertexId> nodes(std::size_t group) const
    {
        return { node.data() + start[group], static_cast<std::size_t>(start[group + 1] - start[group]) };
    }
};

/// Nodes of one group are coupled. Nodes that are in no group have empty rows.
BlockPattern block_pattern(std::size_t node_count, const NodeGroups& groups);
/// Nodes of one element are coupled.
BlockPattern block_pattern(const mesh::TetMesh& mesh);

/// Per group and pair of its nodes, as element_block_map(); group g's pairs begin at the sum of those before it.
std::vector<std::int32_t> group_block_map(const NodeGroups& groups, const BlockPattern& pattern);

/// Per element and pair of local nodes (a >= b, at a (a + 1) / 2 + b): the block they add to; ~block when the block is
/// to be added transposed (the global order of the two nodes is the other way round).
std::vector<std::int32_t> element_block_map(const mesh::TetMesh& mesh, const BlockPattern& pattern);

struct BlockMatrix {
    BlockPattern pattern;
    std::vector<double> values; ///< nine per block, row by row

    /// y = A x for vectors of three entries per node.
    Eigen::VectorXd multiply(const Eigen::VectorXd& x) const;
};

/// All entries, for small matrices: both triangles.
Eigen::MatrixXd dense(const BlockMatrix& matrix);

} // namespace retractor::fem
