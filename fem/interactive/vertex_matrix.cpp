#include "fem/interactive/vertex_matrix.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <utility>

namespace retractor::fem {

namespace {

    /// The upper triangle of the graph of the first `count` vertices.
    SymmetricPattern vertex_graph(const RowOf& row, const std::vector<VertexId>& vertices,
        const std::function<std::int32_t(VertexId)>& number, std::size_t count)
    {
        SymmetricPattern graph;
        graph.column_start.push_back(0);
        for (std::size_t j = 0; j < count; ++j) {
            const std::size_t begin = graph.row.size();
            for (const VertexId v : row(vertices[j]).column)
                if (const std::int32_t i = number(v); i >= 0 && i <= static_cast<std::int32_t>(j))
                    graph.row.push_back(i);
            std::sort(graph.row.begin() + static_cast<std::ptrdiff_t>(begin), graph.row.end());
            graph.column_start.push_back(static_cast<std::int32_t>(graph.row.size()));
        }
        return graph;
    }

} // namespace

SparseMatrix vertex_matrix(
    const RowOf& row, const std::vector<VertexId>& vertices, const std::function<std::int32_t(VertexId)>& number)
{
    SparseMatrix m;
    m.pattern.column_start.push_back(0);
    std::vector<std::pair<std::int32_t, const double*>> blocks;
    for (std::size_t j = 0; j < vertices.size(); ++j) {
        const auto self = static_cast<std::int32_t>(j);
        const OnlineStiffness::Row& full = row(vertices[j]);
        blocks.clear();
        for (std::size_t k = 0; k < full.column.size(); ++k)
            if (const std::int32_t i = number(full.column[k]); i >= 0 && i <= self)
                blocks.emplace_back(i, full.value.data() + 9 * k);
        std::sort(blocks.begin(), blocks.end());
        for (std::int32_t axis = 0; axis < 3; ++axis) {
            for (const auto& [i, block] : blocks)
                for (std::int32_t a = 0; a < (i == self ? axis + 1 : 3); ++a) {
                    m.pattern.row.push_back(3 * i + a);
                    m.values.push_back(block[3 * axis + a]);
                }
            m.pattern.column_start.push_back(static_cast<std::int32_t>(m.pattern.row.size()));
        }
    }
    return m;
}

std::vector<std::int32_t> condensing_order(const RowOf& row, const std::vector<VertexId>& vertices,
    const std::function<std::int32_t(VertexId)>& number, std::size_t kept_from, Ordering ordering)
{
    RETRACTOR_ASSERT(kept_from <= vertices.size());
    std::vector<std::int32_t> order;
    order.reserve(3 * vertices.size());
    const auto add = [&](std::int32_t vertex) {
        for (std::int32_t axis = 0; axis < 3; ++axis)
            order.push_back(3 * vertex + axis);
    };
    if (kept_from > 0) {
        SparseCholesky graph;
        graph.analyse(vertex_graph(row, vertices, number, kept_from), ordering);
        for (const std::int32_t vertex : graph.elimination_order())
            add(vertex);
    }
    for (std::size_t vertex = kept_from; vertex < vertices.size(); ++vertex)
        add(static_cast<std::int32_t>(vertex));
    return order;
}

} // namespace retractor::fem
