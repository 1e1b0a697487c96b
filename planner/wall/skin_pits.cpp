#include "planner/wall/skin_pits.h"

#include "mesh/base/assert.h"
#include "mesh/base/corridor.h"
#include "mesh/base/triangle.h"
#include "mesh/surface/proximity.h"

namespace retractor::planner {

namespace {

    constexpr double kLeastMm = 0.8; ///< half a voxel: the two surfaces are made from the same voxels in two ways
    constexpr double kDeepestMm = 5.0; ///< deeper vertices belong to another surface: a lip, or the region's border
    constexpr double kBesideCutMm = 8.0; ///< thickness of skin and fat at a lip that may be drawn as skin

    /// Of each vertex: whether it has triangles, and all of them are skin.
    std::vector<bool> skin_vertices(const TriMesh& mesh, Label skin)
    {
        const auto count = static_cast<std::size_t>(mesh.vertices.rows());
        std::vector<bool> any(count, false), other(count, false);
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (const VertexId v : mesh.triangles[t])
                (mesh.labels[t] == skin ? any : other)[static_cast<std::size_t>(v)] = true;
        for (std::size_t v = 0; v < count; ++v)
            any[v] = any[v] && !other[v];
        return any;
    }

} // namespace

void lift_pits(
    TriMesh& boundary, const TriMesh& at_rest, const TriMesh& body, const std::vector<Vec3>& incision, Label skin)
{
    RETRACTOR_ASSERT(boundary.labels.size() == boundary.triangles.size());
    RETRACTOR_ASSERT(boundary.vertices.rows() == at_rest.vertices.rows());
    if (body.triangles.empty())
        return;
    const mesh::TriangleProximity surface(body.vertices, body.triangles, kDeepestMm);
    const std::vector<bool> is_skin = skin_vertices(boundary, skin);
    for (Eigen::Index v = 0; v < boundary.vertices.rows(); ++v) {
        const Vec3 place = at_rest.vertices.row(v).transpose();
        if (!is_skin[static_cast<std::size_t>(v)] || polyline_distance(incision, place) < kBesideCutMm)
            continue;
        const auto near = surface.within(place, kDeepestMm);
        if (near.empty() || near.front().point.distance < kLeastMm)
            continue;
        const auto [a, b, c]
            = triangle_corners(body.vertices, body.triangles[static_cast<std::size_t>(near.front().triangle)]);
        const Vec3& weights = near.front().point.barycentric;
        const Vec3 lifted = weights[0] * a + weights[1] * b + weights[2] * c;
        boundary.vertices.row(v) += (lifted - place).transpose();
    }
}

} // namespace retractor::planner
