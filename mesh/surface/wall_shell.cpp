#include "mesh/surface/wall_shell.h"

#include "mesh/base/assert.h"
#include "mesh/base/disjoint_sets.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace retractor::mesh {

namespace {

    using Edge = std::pair<VertexId, VertexId>;

    Vec3 corner_point(const TriMesh& surface, std::size_t t, std::size_t c)
    {
        return surface.vertices.row(surface.triangles[t][c]).transpose();
    }

    /// Pairs of triangles at an edge with the body between them. Seen along the edge p, q, the body lies next to a
    /// triangle that runs from p to q, in the direction of falling angles.
    std::vector<std::array<std::size_t, 2>> pairs_across(
        const TriMesh& surface, const Edge& edge, const std::vector<std::size_t>& triangles)
    {
        if (triangles.size() == 2)
            return { { triangles[0], triangles[1] } };
        const Vec3 p = surface.vertices.row(edge.first).transpose();
        const Vec3 along = (Vec3(surface.vertices.row(edge.second).transpose()) - p).normalized();
        const Vec3 x = along.unitOrthogonal(), y = along.cross(x);
        struct Around {
            double angle;
            std::size_t triangle;
            bool forward;
        };
        std::vector<Around> round;
        for (const std::size_t t : triangles) {
            const auto& v = surface.triangles[t];
            for (std::size_t c = 0; c < 3; ++c)
                if (v[c] != edge.first && v[c] != edge.second) {
                    const Vec3 d = corner_point(surface, t, c) - p;
                    round.push_back({ std::atan2(d.dot(y), d.dot(x)), t, v[(c + 1) % 3] == edge.first });
                }
        }
        std::sort(round.begin(), round.end(), [](const Around& a, const Around& b) { return a.angle < b.angle; });
        std::vector<std::array<std::size_t, 2>> pairs;
        for (std::size_t i = 0; i < round.size(); ++i) {
            const Around& before = round[(i + round.size() - 1) % round.size()];
            if (round[i].forward == before.forward)
                throw SolverError("the surface is torn along an edge", in_words(p));
            if (round[i].forward)
                pairs.push_back({ before.triangle, round[i].triangle });
        }
        return pairs;
    }

    /// Sets of corners (3 * triangle + corner) that form one vertex of the surface: corners are joined across edges,
    /// not at points.
    DisjointSets<> joined_corners(const TriMesh& surface)
    {
        DisjointSets<> corners(3 * surface.triangles.size());
        std::map<Edge, std::vector<std::size_t>> triangles_at;
        for (std::size_t t = 0; t < surface.triangles.size(); ++t)
            for (std::size_t c = 0; c < 3; ++c)
                triangles_at[std::minmax(surface.triangles[t][c], surface.triangles[t][(c + 1) % 3])].push_back(t);
        const auto corner = [&](std::size_t t, VertexId v) {
            const auto& triangle = surface.triangles[t];
            return 3 * t + static_cast<std::size_t>(std::find(triangle.begin(), triangle.end(), v) - triangle.begin());
        };
        for (const auto& [edge, triangles] : triangles_at)
            for (const auto& [a, b] : pairs_across(surface, edge, triangles))
                for (const VertexId v : { edge.first, edge.second })
                    corners.join(corner(a, v), corner(b, v));
        return corners;
    }

    /// Outward unit normals of vertices, weighted by the triangles' angles.
    std::vector<Vec3> angle_weighted_normals(const TriMesh& surface)
    {
        std::vector<Vec3> normals(static_cast<std::size_t>(surface.vertices.rows()), Vec3::Zero());
        for (std::size_t t = 0; t < surface.triangles.size(); ++t)
            for (std::size_t c = 0; c < 3; ++c) {
                const Vec3 p = corner_point(surface, t, c);
                const Vec3 a = corner_point(surface, t, (c + 1) % 3) - p, b = corner_point(surface, t, (c + 2) % 3) - p;
                const Vec3 area = a.cross(b);
                normals[static_cast<std::size_t>(surface.triangles[t][c])]
                    += std::atan2(area.norm(), a.dot(b)) * area.normalized();
            }
        for (Vec3& normal : normals)
            normal.normalize();
        return normals;
    }

    std::vector<std::vector<VertexId>> neighbours_of(const TriMesh& surface)
    {
        std::vector<std::vector<VertexId>> neighbours(static_cast<std::size_t>(surface.vertices.rows()));
        for (const auto& triangle : surface.triangles)
            for (std::size_t c = 0; c < 3; ++c) // a closed oriented surface has every edge once in each direction
                neighbours[static_cast<std::size_t>(triangle[c])].push_back(triangle[(c + 1) % 3]);
        return neighbours;
    }

    /// Smooths the creases between a mesher's triangles and keeps the volume (Taubin 1995).
    void smooth_creases(TriMesh& surface, const std::vector<std::vector<VertexId>>& neighbours)
    {
        constexpr int kRounds = 10;
        constexpr double kIn = 0.5, kOut = -0.53;
        for (int round = 0; round < kRounds; ++round)
            for (const double step : { kIn, kOut }) {
                const Points before = surface.vertices;
                for (std::size_t v = 0; v < neighbours.size(); ++v) {
                    const auto row = static_cast<Eigen::Index>(v);
                    const Eigen::RowVector3d mean = before(neighbours[v], Eigen::all).colwise().mean();
                    surface.vertices.row(row) += step * (mean - before.row(row));
                }
            }
    }

    /// Distance (mm) straight through the organ to the surface on the other side, or `most` when that is nearer.
    double way_through(const TriMesh& surface, const Vec3& from, const Vec3& inward, double most)
    {
        constexpr double kStart = 1e-6; // share of `most`; skips the surface at the start
        double nearest = most;
        for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
            const Vec3 a = corner_point(surface, t, 0);
            const Vec3 u = corner_point(surface, t, 1) - a, v = corner_point(surface, t, 2) - a;
            const Vec3 normal = u.cross(v);
            const double along = normal.dot(inward);
            if (along <= 0.0) // the other side faces away from a point inside
                continue;
            const double way = normal.dot(a - from) / along;
            if (way <= kStart * most || way >= nearest)
                continue;
            const Vec3 d = from + way * inward - a;
            const double s = d.cross(v).dot(normal), r = u.cross(d).dot(normal), whole = normal.squaredNorm();
            if (s >= 0.0 && r >= 0.0 && s + r <= whole)
                nearest = way;
        }
        return nearest;
    }

    /// The three tetrahedra of the prism between triangle (a, b, c) and the triangle beneath. The outer vertices go
    /// down one after another in the order of their numbers, so that neighbours divide their common side alike.
    std::array<std::array<VertexId, 4>, 3> prism(const std::array<VertexId, 3>& triangle, VertexId outer)
    {
        std::array<VertexId, 3> v = triangle;
        std::sort(v.begin(), v.end());
        const bool even = (v[0] == triangle[0] && v[1] == triangle[1]) || (v[0] == triangle[1] && v[1] == triangle[2])
            || (v[0] == triangle[2] && v[1] == triangle[0]);
        std::array<std::array<VertexId, 4>, 3> tets {};
        for (std::size_t i = 0; i < 3; ++i) {
            std::size_t n = 0;
            for (std::size_t k = 0; k <= i; ++k)
                tets[i][n++] = v[k];
            for (std::size_t k = i; k < 3; ++k)
                tets[i][n++] = v[k] + outer;
            if (even == (i != 1))
                std::swap(tets[i][2], tets[i][3]);
        }
        return tets;
    }

    /// The wall beneath each vertex of the outside.
    struct Layer {
        std::vector<Vec3> inward; ///< unit directions
        std::vector<double> thickness; ///< mm
    };

    /// The wall with the requested thickness (mm), thinned where the organ is narrow.
    Layer layer_beneath(const TriMesh& outer, double thickness_mm)
    {
        constexpr double kShareOfWidth = 0.3; // leaves room between the walls of both sides
        Layer layer { angle_weighted_normals(outer), {} };
        for (std::size_t v = 0; v < layer.inward.size(); ++v) {
            layer.inward[v] = -layer.inward[v];
            layer.thickness.push_back(kShareOfWidth
                * way_through(outer, outer.vertices.row(static_cast<Eigen::Index>(v)).transpose(), layer.inward[v],
                    thickness_mm / kShareOfWidth));
        }
        return layer;
    }

    /// Three tetrahedra beneath each triangle; the inner vertices have no positions yet.
    TetMesh prisms_beneath(const TriMesh& outer, Label label)
    {
        const Eigen::Index n = outer.vertices.rows();
        TetMesh mesh;
        mesh.vertices.resize(2 * n, 3);
        mesh.vertices.topRows(n) = outer.vertices;
        for (const auto& triangle : outer.triangles)
            for (const auto& tet : prism(triangle, static_cast<VertexId>(n))) {
                mesh.nodes.insert(mesh.nodes.end(), tet.begin(), tet.end());
                mesh.labels.push_back(label);
            }
        return mesh;
    }

    /// Puts the inner vertices at the layer's thickness. @throws SolverError naming a place where almost no wall is
    /// left
    void place_inside(TetMesh& mesh, const Layer& layer, double thickness_mm)
    {
        constexpr double kThinnest = 0.05; // share of the requested thickness
        RETRACTOR_ASSERT(static_cast<std::size_t>(mesh.vertices.rows()) == 2 * layer.thickness.size());
        for (std::size_t v = 0; v < layer.thickness.size(); ++v) {
            const Vec3 outside = mesh.vertices.row(static_cast<Eigen::Index>(v)).transpose();
            if (layer.thickness[v] < kThinnest * thickness_mm)
                throw SolverError("no wall of " + std::to_string(thickness_mm)
                        + " mm fits where the organ is so narrow or bends so sharply: a thinner wall or other edges "
                          "may help",
                    in_words(outside));
            mesh.vertices.row(static_cast<Eigen::Index>(layer.thickness.size() + v))
                = (outside + layer.thickness[v] * layer.inward[v]).transpose();
        }
    }

    /// One entry per vertex of the outside: 1 when an element beneath is turned over or nearly flat.
    std::vector<char> where_too_thick(const TetMesh& mesh, const TriMesh& outer, const Layer& layer)
    {
        constexpr double kLeastVolume = 0.2; // share of the volume of an element beneath a flat triangle
        std::vector<char> too_thick(layer.thickness.size(), 0);
        for (std::size_t t = 0; t < outer.triangles.size(); ++t) {
            const auto& triangle = outer.triangles[t];
            const double area = triangle_area(outer.vertices, triangle);
            double mean = 0.0;
            for (const VertexId v : triangle)
                mean += layer.thickness[static_cast<std::size_t>(v)] / 3.0;
            for (std::size_t k = 0; k < 3; ++k)
                if (tet_volume(mesh, static_cast<TetId>(3 * t + k)) < kLeastVolume * area * mean / 3.0)
                    for (const VertexId v : triangle)
                        too_thick[static_cast<std::size_t>(v)] = 1;
        }
        return too_thick;
    }

    void thin(Layer& layer, const std::vector<char>& where, const std::vector<std::vector<VertexId>>& neighbours)
    {
        constexpr double kThinner = 0.8; // factor per round
        const std::vector<Vec3> before = layer.inward;
        for (std::size_t v = 0; v < where.size(); ++v) {
            if (where[v] == 0)
                continue;
            layer.thickness[v] *= kThinner;
            Vec3 way = before[v]; // vertices on a crease take the direction of their neighbours
            for (const VertexId other : neighbours[v])
                way += before[static_cast<std::size_t>(other)] / static_cast<double>(neighbours[v].size());
            layer.inward[v] = way.normalized();
        }
    }

} // namespace

TriMesh closed_surfaces(const TetMesh& mesh)
{
    TriMesh all { mesh.vertices, {}, {} };
    for (const TetFace& face : boundary_faces(mesh))
        all.triangles.push_back(face_vertices(mesh, face));
    DisjointSets<> corners = joined_corners(all);
    TriMesh surface;
    std::map<std::size_t, VertexId> number;
    std::vector<VertexId> origin;
    for (std::size_t t = 0; t < all.triangles.size(); ++t) {
        std::array<VertexId, 3> triangle {};
        for (std::size_t c = 0; c < 3; ++c) {
            const auto [at, is_new] = number.emplace(corners.root(3 * t + c), static_cast<VertexId>(number.size()));
            triangle[c] = at->second;
            if (is_new)
                origin.push_back(all.triangles[t][c]);
        }
        surface.triangles.push_back(triangle);
    }
    surface.vertices = mesh.vertices(origin, Eigen::all);
    return surface;
}

TriMesh largest_closed_surface(const TetMesh& mesh)
{
    const TriMesh all = closed_surfaces(mesh);
    DisjointSets<> pieces(static_cast<std::size_t>(all.vertices.rows()));
    for (const auto& triangle : all.triangles)
        for (std::size_t c = 1; c < 3; ++c)
            pieces.join(static_cast<std::size_t>(triangle[0]), static_cast<std::size_t>(triangle[c]));
    const auto piece_of = [&](std::size_t t) { return pieces.root(static_cast<std::size_t>(all.triangles[t][0])); };
    std::map<std::size_t, double> volume; // volume of each surface; negative for a cavity
    for (std::size_t t = 0; t < all.triangles.size(); ++t)
        volume[piece_of(t)]
            += corner_point(all, t, 0).dot(corner_point(all, t, 1).cross(corner_point(all, t, 2))) / 6.0;
    if (volume.empty())
        return {};
    const auto largest = std::max_element(
        volume.begin(), volume.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    TriMesh surface;
    std::vector<VertexId> number(static_cast<std::size_t>(all.vertices.rows()), -1), origin;
    for (std::size_t t = 0; t < all.triangles.size(); ++t) {
        if (piece_of(t) != largest->first)
            continue;
        std::array<VertexId, 3> triangle = all.triangles[t];
        for (VertexId& v : triangle) {
            VertexId& n = number[static_cast<std::size_t>(v)];
            if (n < 0) {
                n = static_cast<VertexId>(origin.size());
                origin.push_back(v);
            }
            v = n;
        }
        surface.triangles.push_back(triangle);
    }
    surface.vertices = all.vertices(origin, Eigen::all);
    return surface;
}

WallShell make_wall_shell(const TriMesh& closed, double thickness_mm, Label label)
{
    if (!(std::isfinite(thickness_mm) && thickness_mm > 0.0))
        throw InputError("a wall's thickness must be positive, got " + std::to_string(thickness_mm) + " mm", "wall");
    TriMesh outer = closed;
    const auto neighbours = neighbours_of(outer);
    smooth_creases(outer, neighbours);
    Layer layer = layer_beneath(outer, thickness_mm);
    WallShell shell;
    shell.mesh = prisms_beneath(outer, label);
    for (;;) {
        place_inside(shell.mesh, layer, thickness_mm);
        const std::vector<char> too_thick = where_too_thick(shell.mesh, outer, layer);
        if (std::find(too_thick.begin(), too_thick.end(), 1) == too_thick.end())
            break;
        thin(layer, too_thick, neighbours);
    }
    constexpr double kSame = 0.999;
    shell.thinnest_mm = thickness_mm;
    for (const double t : layer.thickness) {
        shell.thinned += t < kSame * thickness_mm ? 1 : 0;
        shell.thinnest_mm = std::min(shell.thinnest_mm, t);
    }
    return shell;
}

} // namespace retractor::mesh
