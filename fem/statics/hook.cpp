#include "fem/statics/hook.h"

#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <utility>

namespace retractor::fem {

namespace {

    std::string place(const Vec3& p)
    {
        std::ostringstream text;
        text.precision(4);
        text << "(" << p.x() << ", " << p.y() << ", " << p.z() << ") mm";
        return text.str();
    }

    struct Rectangle {
        Vec3 centre, along, depth, normal; ///< unit axes
        double half_width = 0.0, half_height = 0.0;

        bool covers(const Vec3& p) const
        {
            constexpr double kRoundOff = 1e-9; // includes nodes on the border of the patch
            const Vec3 d = p - centre;
            const double reach = 2.0 * std::max(half_width, half_height);
            return std::abs(d.dot(along)) <= half_width * (1.0 + kRoundOff)
                && std::abs(d.dot(depth)) <= half_height * (1.0 + kRoundOff) && std::abs(d.dot(normal)) <= reach;
        }
    };

    Rectangle rectangle(
        const Vec3& centre, const Vec3& along, const Vec3& depth, double width, double height, const std::string& where)
    {
        if (!centre.allFinite() || !along.allFinite() || !depth.allFinite() || !std::isfinite(width)
            || !std::isfinite(height))
            throw InputError("a number of the hook's placement is not finite", where);
        if (!(width > 0.0) || !(height > 0.0))
            throw InputError("a hook patch needs a positive width and height", where);
        constexpr double kParallel = 1e-6; // sine of the angle between the axes
        const Vec3 normal = along.normalized().cross(depth.normalized());
        if (!(normal.norm() > kParallel))
            throw InputError("the hook's axis along the lip and its depth axis are zero or parallel", where);
        const Vec3 unit_along = along.normalized();
        const Vec3 unit_normal = normal.normalized();
        return { centre, unit_along, unit_normal.cross(unit_along), unit_normal, 0.5 * width, 0.5 * height };
    }

    /// Whether some node lies off the line through the first node and the node farthest from the first node.
    bool spans_a_plane(const mesh::TetMesh& mesh, const std::vector<VertexId>& nodes)
    {
        if (nodes.size() < 3)
            return false;
        const Vec3 a = point_at(mesh.vertices, nodes.front());
        Vec3 far = Vec3::Zero();
        for (const VertexId v : nodes)
            if ((point_at(mesh.vertices, v) - a).squaredNorm() > far.squaredNorm())
                far = point_at(mesh.vertices, v) - a;
        constexpr double kOnLine = 1e-6; // distance from the line, relative to the length
        return std::any_of(nodes.begin(), nodes.end(),
            [&](VertexId v) { return far.cross(point_at(mesh.vertices, v) - a).norm() > kOnLine * far.squaredNorm(); });
    }

    std::string nearest_node(const mesh::TetMesh& mesh, const std::set<VertexId>& lip, const Vec3& centre)
    {
        double best = std::numeric_limits<double>::max();
        VertexId nearest = -1;
        for (const VertexId v : lip)
            if (const double d = (point_at(mesh.vertices, v) - centre).norm(); d < best) {
                best = d;
                nearest = v;
            }
        if (nearest < 0)
            return "the lip has no faces";
        std::ostringstream text;
        text.precision(4);
        text << "the nearest lip node is " << nearest << " at " << place(point_at(mesh.vertices, nearest)) << ", "
             << best << " mm away";
        return text.str();
    }

    /// Adds the midpoints of element edges whose two ends are under the patch and on one lip face.
    void add_midpoints(
        const mesh::TetMesh& mesh, std::span<const std::array<VertexId, 3>> lip_faces, std::set<VertexId>& patch)
    {
        std::set<std::pair<VertexId, VertexId>> edges;
        for (const auto& face : lip_faces)
            for (std::size_t i = 0; i < 3; ++i)
                if (const VertexId a = face[i], b = face[(i + 1) % 3]; patch.contains(a) && patch.contains(b))
                    edges.insert(std::minmax(a, b));
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const auto n = mesh.tet(t);
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e) {
                const VertexId a = n[static_cast<std::size_t>(mesh::kTetEdges[e][0])];
                const VertexId b = n[static_cast<std::size_t>(mesh::kTetEdges[e][1])];
                if (edges.contains(std::minmax(a, b)))
                    patch.insert(n[4 + e]);
            }
        }
    }

} // namespace

std::vector<VertexId> hook_patch_nodes(const mesh::TetMesh& mesh, std::span<const std::array<VertexId, 3>> lip_faces,
    const Vec3& centre, const Vec3& along, const Vec3& depth, double width_mm, double height_mm, std::string_view name)
{
    const std::string where = "hook '" + std::string(name) + "' at " + place(centre);
    const Rectangle patch = rectangle(centre, along, depth, width_mm, height_mm, where);
    std::set<VertexId> lip;
    for (const auto& face : lip_faces)
        for (const VertexId v : face) {
            if (v < 0 || v >= mesh.vertices.rows())
                throw InputError("lip vertex " + std::to_string(v) + " is out of range", where);
            lip.insert(v);
        }
    std::set<VertexId> covered;
    for (const VertexId v : lip)
        if (patch.covers(point_at(mesh.vertices, v)))
            covered.insert(v);
    if (!spans_a_plane(mesh, { covered.begin(), covered.end() }))
        throw InputError("the patch covers " + std::to_string(covered.size())
                + " lip node(s), not three that span a surface; " + nearest_node(mesh, lip, centre),
            where);
    if (mesh.nodes_per_tet == 10)
        add_midpoints(mesh, lip_faces, covered);
    return { covered.begin(), covered.end() };
}

} // namespace retractor::fem
