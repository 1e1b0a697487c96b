#include "planner/wall/skin_pits.h"

#include "mesh/base/assert.h"
#include "mesh/base/corridor.h"
#include "mesh/base/triangle.h"
#include "mesh/surface/proximity.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <map>
#include <optional>

namespace retractor::planner {

namespace {

    constexpr double kLeastMm = 0.8; ///< half a voxel: the two surfaces are made from the same voxels in two ways
    /// Shallower pits are lifted where a triangle is steeper than 40 degrees: light makes a slit of it, too.
    constexpr double kSteepCosine = 0.77;
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

    /// The body's surface, and the place on it nearest to a point.
    struct Body {
        struct Place {
            Vec3 at, outward; ///< outward: unit normal
            double distance = 0.0;
        };

        explicit Body(const TriMesh& mesh)
            : surface(mesh)
            , proximity(mesh.vertices, mesh.triangles, kDeepestMm)
        {
        }
        /// @return nothing beyond kDeepestMm
        std::optional<Place> nearest(const Vec3& p) const
        {
            const auto near = proximity.within(p, kDeepestMm);
            if (near.empty())
                return std::nullopt;
            const auto [a, b, c] = triangle_corners(
                surface.vertices, surface.triangles[static_cast<std::size_t>(near.front().triangle)]);
            const Vec3& weights = near.front().point.barycentric;
            return Place { weights[0] * a + weights[1] * b + weights[2] * c, unit_normal(a, b, c),
                near.front().point.distance };
        }

        const TriMesh& surface;
        mesh::TriangleProximity proximity;
    };

    /// A vertex that is lifted out of a pit.
    struct Lifted {
        Vec3 outward;
        std::vector<std::size_t> triangles; ///< round it
    };

    /// The cosine of the steepest slope against the body of the triangles round a vertex.
    double steepest(const TriMesh& mesh, const std::vector<std::size_t>& triangles, const Vec3& outward)
    {
        double least = 1.0;
        for (const std::size_t t : triangles) {
            const auto [a, b, c] = triangle_corners(mesh.vertices, mesh.triangles[t]);
            least = std::min(least, unit_normal(a, b, c).dot(outward));
        }
        return least;
    }

    /// A pit may reach under its rim: a vertex lifted straight up then lies beyond the rim, and a triangle is turned
    /// over. Such vertices move along the body's surface to the middle of their neighbours.
    /// @param places of all vertices; those of `lifted` are changed
    void unfold(Points& places, const TriMesh& mesh, std::map<VertexId, Lifted>& lifted, const Body& body)
    {
        constexpr int kSweeps = 10; // neighbours in one pit are lifted together
        const auto is_folded = [&](const Lifted& vertex) {
            return std::any_of(vertex.triangles.begin(), vertex.triangles.end(), [&](std::size_t t) {
                const auto [a, b, c] = triangle_corners(places, mesh.triangles[t]);
                return (b - a).cross(c - a).dot(vertex.outward) <= 0.0;
            });
        };
        for (int sweep = 0; sweep < kSweeps; ++sweep) {
            bool any = false;
            for (auto& [v, vertex] : lifted) {
                if (!is_folded(vertex))
                    continue;
                any = true;
                Vec3 sum = Vec3::Zero();
                int count = 0;
                for (const std::size_t t : vertex.triangles)
                    for (const VertexId corner : mesh.triangles[t])
                        if (corner != v) {
                            sum += places.row(corner).transpose();
                            ++count;
                        }
                if (const auto place = body.nearest(sum / count)) {
                    places.row(v) = place->at.transpose();
                    vertex.outward = place->outward;
                }
            }
            if (!any)
                return;
        }
    }

} // namespace

void lift_pits(
    TriMesh& boundary, const TriMesh& at_rest, const TriMesh& body, const std::vector<Vec3>& incision, Label skin)
{
    RETRACTOR_ASSERT(boundary.labels.size() == boundary.triangles.size());
    RETRACTOR_ASSERT(boundary.vertices.rows() == at_rest.vertices.rows());
    if (body.triangles.empty())
        return;
    const Body surface(body);
    const std::vector<bool> is_skin = skin_vertices(boundary, skin);
    std::vector<std::vector<std::size_t>> triangles_of(static_cast<std::size_t>(at_rest.vertices.rows()));
    for (std::size_t t = 0; t < at_rest.triangles.size(); ++t)
        for (const VertexId v : at_rest.triangles[t])
            triangles_of[static_cast<std::size_t>(v)].push_back(t);
    Points places = at_rest.vertices;
    std::map<VertexId, Lifted> lifted;
    for (Eigen::Index v = 0; v < places.rows(); ++v) {
        const Vec3 place = places.row(v).transpose();
        if (!is_skin[static_cast<std::size_t>(v)] || polyline_distance(incision, place) < kBesideCutMm)
            continue;
        const std::optional<Body::Place> near = surface.nearest(place);
        const auto& triangles = triangles_of[static_cast<std::size_t>(v)];
        if (!near || (near->distance < kLeastMm && steepest(at_rest, triangles, near->outward) > kSteepCosine))
            continue;
        places.row(v) = near->at.transpose();
        lifted[static_cast<VertexId>(v)] = { near->outward, triangles };
    }
    unfold(places, boundary, lifted, surface);
    for (const auto& [v, vertex] : lifted)
        boundary.vertices.row(v) += places.row(v) - at_rest.vertices.row(v);
}

} // namespace retractor::planner
