#include "fem/block_matrix.h"

#include "mesh/geometry.h"

#include <algorithm>

namespace retractor {

namespace {

    using Block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

    /// Elements round each node, compressed.
    struct NodeElements {
        std::vector<std::size_t> start;
        std::vector<TetId> element;
    };

    NodeElements elements_round_nodes(const TetMesh& mesh)
    {
        NodeElements around;
        around.start.assign(mesh.vertex_count() + 1, 0);
        for (const VertexId v : mesh.nodes)
            ++around.start[static_cast<std::size_t>(v) + 1];
        for (std::size_t v = 0; v < mesh.vertex_count(); ++v)
            around.start[v + 1] += around.start[v];
        around.element.resize(mesh.nodes.size());
        std::vector<std::size_t> next(around.start.begin(), around.start.end() - 1);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            for (const VertexId v : mesh.tet(t))
                around.element[next[static_cast<std::size_t>(v)]++] = t;
        return around;
    }

} // namespace

BlockPattern block_pattern(const TetMesh& mesh)
{
    const NodeElements around = elements_round_nodes(mesh);
    BlockPattern pattern;
    pattern.row_start.push_back(0);
    std::vector<VertexId> seen_by(mesh.vertex_count(), -1);
    for (VertexId row = 0; row < static_cast<VertexId>(mesh.vertex_count()); ++row) {
        const auto begin = pattern.column.size();
        for (std::size_t i = around.start[static_cast<std::size_t>(row)];
             i < around.start[static_cast<std::size_t>(row) + 1]; ++i)
            for (const VertexId column : mesh.tet(around.element[i]))
                if (column <= row && seen_by[static_cast<std::size_t>(column)] != row) {
                    seen_by[static_cast<std::size_t>(column)] = row;
                    pattern.column.push_back(column);
                }
        std::sort(pattern.column.begin() + static_cast<std::ptrdiff_t>(begin), pattern.column.end());
        pattern.row_start.push_back(static_cast<std::int32_t>(pattern.column.size()));
    }
    return pattern;
}

std::vector<std::int32_t> element_block_map(const TetMesh& mesh, const BlockPattern& pattern)
{
    const auto find = [&](VertexId row, VertexId column) {
        const auto begin = pattern.column.begin() + pattern.row_start[static_cast<std::size_t>(row)];
        const auto end = pattern.column.begin() + pattern.row_start[static_cast<std::size_t>(row) + 1];
        return static_cast<std::int32_t>(std::lower_bound(begin, end, column) - pattern.column.begin());
    };
    const auto n = static_cast<std::size_t>(mesh.nodes_per_tet);
    std::vector<std::int32_t> map;
    map.reserve(mesh.tet_count() * n * (n + 1) / 2);
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
        const auto nodes = mesh.tet(t);
        for (std::size_t a = 0; a < n; ++a)
            for (std::size_t b = 0; b <= a; ++b)
                map.push_back(nodes[a] >= nodes[b] ? find(nodes[a], nodes[b]) : ~find(nodes[b], nodes[a]));
    }
    return map;
}

Eigen::VectorXd BlockMatrix::multiply(const Eigen::VectorXd& x) const
{
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

} // namespace retractor
