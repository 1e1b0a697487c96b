#include "mesh/tetrahedra/insert_vertex.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <vector>

namespace retractor::mesh {

VertexId insert_vertex(TetMesh& mesh, const std::array<VertexId, 3>& face, const Vec3& weights)
{
    RETRACTOR_ASSERT(mesh.nodes_per_tet == 4);
    RETRACTOR_ASSERT(weights.minCoeff() >= 0.0);
    // At least one of three weights that sum to 1 is a third, so that a corner remains.
    std::vector<VertexId> corners;
    Vec3 place = Vec3::Zero();
    double sum = 0.0;
    for (int i = 0; i < 3; ++i)
        if (weights[i] >= kLeastInsertionWeight) {
            corners.push_back(face[static_cast<std::size_t>(i)]);
            place += weights[i] * point_at(mesh.vertices, corners.back());
            sum += weights[i];
        }
    RETRACTOR_ASSERT(!corners.empty());
    if (corners.size() == 1)
        return corners.front();

    const auto added = static_cast<VertexId>(mesh.vertex_count());
    mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
    mesh.vertices.row(added) = (place / sum).transpose();
    const std::size_t elements = mesh.tet_count();
    for (std::size_t t = 0; t < elements; ++t) {
        std::array<VertexId, 4> nodes {};
        std::copy_n(mesh.nodes.begin() + static_cast<std::ptrdiff_t>(4 * t), 4, nodes.begin());
        if (!std::ranges::all_of(corners, [&](VertexId v) { return std::ranges::find(nodes, v) != nodes.end(); }))
            continue;
        // Each part has the new vertex in place of one of the corners.
        for (std::size_t i = 0; i < corners.size(); ++i) {
            std::array<VertexId, 4> part = nodes;
            std::ranges::replace(part, corners[i], added);
            if (i == 0) {
                std::ranges::copy(part, mesh.nodes.begin() + static_cast<std::ptrdiff_t>(4 * t));
            } else {
                mesh.nodes.insert(mesh.nodes.end(), part.begin(), part.end());
                mesh.labels.push_back(mesh.labels[t]);
            }
        }
    }
    return added;
}

} // namespace retractor::mesh
