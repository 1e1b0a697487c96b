#include "fem/linear_algebra/block_matrix.h"

#include "mesh/base/assert.h"
#include "mesh/base/geometry.h"

#include <algorithm>

namespace retractor::fem {

namespace {

    using Block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

    NodeGroups elements_as_groups(const mesh::TetMesh& mesh)
    {
        NodeGroups groups;
        groups.node = mesh.nodes;
        for (std::size_t t = 1; t <= mesh.tet_count(); ++t)
            groups.start.push_back(static_cast<std::int32_t>(t) * mesh.nodes_per_tet);
        return groups;
    }

    /// The groups of each node, in compressed form.
    struct NodeMembership {
        std::vector<std::size_t> start;
        std::vector<std::int32_t> group;
    };

    NodeMembership groups_round_nodes(std::size_t node_count, const NodeGroups& groups)
    {
        NodeMembership around;
        around.start.assign(node_count + 1, 0);
        for (const VertexId v : groups.node)
            ++around.start[static_cast<std::size_t>(v) + 1];
        for (std::size_t v = 0; v < node_count; ++v)
            around.start[v + 1] += around.start[v];
        around.group.resize(groups.node.size());
        std::vector<std::size_t> next(around.start.begin(), around.start.end() - 1);
        for (std::size_t g = 0; g < groups.count(); ++g)
            for (const VertexId v : groups.nodes(g))
                around.group[next[static_cast<std::size_t>(v)]++] = static_cast<std::int32_t>(g);
        return around;
    }

} // namespace

BlockPattern block_pattern(std::size_t node_count, const NodeGroups& groups)
{
    const NodeMembership around = groups_round_nodes(node_count, groups);
    BlockPattern pattern;
    pattern.row_start.push_back(0);
    std::vector<VertexId> seen_by(node_count, -1);
    for (VertexId row = 0; row < static_cast<VertexId>(node_count); ++row) {
        const auto begin = pattern.column.size();
        for (std::size_t i = around.start[static_cast<std::size_t>(row)];
             i < around.start[static_cast<std::size_t>(row) + 1]; ++i)
            for (const VertexId column : groups.nodes(static_cast<std::size_t>(around.group[i])))
                if (column <= row && seen_by[static_cast<std::size_t>(column)] != row) {
                    seen_by[static_cast<std::size_t>(column)] = row;
                    pattern.column.push_back(column);
                }
        std::sort(pattern.column.begin() + static_cast<std::ptrdiff_t>(begin), pattern.column.end());
        pattern.row_start.push_back(static_cast<std::int32_t>(pattern.column.size()));
    }
    return pattern;
}

BlockPattern block_pattern(const mesh::TetMesh& mesh)
{
    return block_pattern(mesh.vertex_count(), elements_as_groups(mesh));
}

std::vector<std::int32_t> group_block_map(const NodeGroups& groups, const BlockPattern& pattern)
{
    const auto find = [&](VertexId row, VertexId column) {
        const auto begin = pattern.column.begin() + pattern.row_start[static_cast<std::size_t>(row)];
        const auto end = pattern.column.begin() + pattern.row_start[static_cast<std::size_t>(row) + 1];
        return static_cast<std::int32_t>(std::lower_bound(begin, end, column) - pattern.column.begin());
    };
    std::vector<std::int32_t> map;
    for (std::size_t g = 0; g < groups.count(); ++g) {
        const auto nodes = groups.nodes(g);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            for (std::size_t b = 0; b <= a; ++b)
                map.push_back(nodes[a] >= nodes[b] ? find(nodes[a], nodes[b]) : ~find(nodes[b], nodes[a]));
    }
    return map;
}

std::vector<std::int32_t> element_block_map(const mesh::TetMesh& mesh, const BlockPattern& pattern)
{
    return group_block_map(elements_as_groups(mesh), pattern);
}

Eigen::VectorXd BlockMatrix::multiply(const Eigen::VectorXd& x) const
{
    RETRACTOR_ASSERT(x.size() == static_cast<Eigen::Index>(3 * pattern.row_count()));
    RETRACTOR_ASSERT(values.size() == 9 * pattern.block_count());
    Eigen::VectorXd y = Eigen::VectorXd::Zero(x.size());
    for (std::size_t row = 0; row < pattern.row_count(); ++row) {
        const auto r = static_cast<Eigen::Index>(3 * row);
        const Vec3 x_row = x.segment<3>(r);
        Vec3 sum = Vec3::Zero();
        for (auto i = pattern.row_start[row]; i < pattern.row_start[row + 1]; ++i) {
            const Block block(values.data() + 9 * static_cast<std::size_t>(i));
            const auto c = 3 * static_cast<Eigen::Index>(pattern.column[static_cast<std::size_t>(i)]);
            sum.noalias() += block * x.segment<3>(c);
            if (c != r)
                y.segment<3>(c).noalias() += block.transpose() * x_row;
        }
        y.segment<3>(r) += sum;
    }
    return y;
}

} // namespace retractor::fem
