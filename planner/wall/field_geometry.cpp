#include "planner/wall/field_geometry.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <queue>
#include <set>
#include <string>

namespace retractor::planner {

namespace {

    /// Step (mm) along a face's normal to find the change of the depth below the blade's line.
    constexpr double kDepthStep = 0.01;
    /// A face belongs to the surface through which the blade entered when its normal points at least this much against
    /// the blade (about 70 degrees). Beyond this angle the face is an end of a piece of tissue, not its skin.
    constexpr double kFacesBlade = 0.34;
    /// Edges that lie deeper below the blade's top than the shallowest edge by less than this are of one skin, mm. No
    /// wall of a chest is thinner.
    constexpr double kOneSkinMm = 5.0;
    /// Lips are closed below this share of the cut's length squared (as an area). The plane is then the caller's.
    constexpr double kClosedArea = 1e-6;

    // ---- finding the edge -----------------------------------------------------------------------------

    using Edge = std::array<VertexId, 2>;
    Edge edge_of(VertexId a, VertexId b) { return a < b ? Edge { a, b } : Edge { b, a }; }

    using FaceKey = std::array<VertexId, 3>;
    FaceKey face_key(const mesh::TetMesh& mesh, const mesh::TetFace& face)
    {
        FaceKey key = mesh::face_vertices(mesh, face);
        std::sort(key.begin(), key.end());
        return key;
    }

    std::vector<Edge> face_edges(const mesh::TetMesh& mesh, const mesh::TetFace& face)
    {
        const auto v = mesh::face_vertices(mesh, face);
        return { edge_of(v[0], v[1]), edge_of(v[1], v[2]), edge_of(v[2], v[0]) };
    }

    /// Slope of the depth below the blade's line along a face's outward normal: 1 for skin square to the blade.
    double rise(const mesh::TetMesh& mesh, const mesh::TetFace& face, const mesh::SweptBlade& blade)
    {
        const auto v = mesh::face_vertices(mesh, face);
        const auto [a, b, c] = triangle_corners(mesh.vertices, v);
        const Vec3 normal = unit_normal(a, b, c), middle = (a + b + c) / 3.0;
        return (blade.coordinates(middle - kDepthStep * normal).depth
                   - blade.coordinates(middle + kDepthStep * normal).depth)
            / (2.0 * kDepthStep);
    }

    /// The edges of one side's lip that border on skin.
    std::set<Edge> skin_rim(const mesh::TetMesh& mesh, std::span<const mesh::LipFace> lips, int side,
        const std::set<FaceKey>& lip_keys, const std::vector<mesh::TetFace>& boundary, const mesh::SweptBlade& blade)
    {
        std::set<Edge> lip_edges;
        for (const mesh::LipFace& lip : lips)
            if (lip.side == side)
                for (const Edge& edge : face_edges(mesh, lip.face))
                    lip_edges.insert(edge);
        std::set<Edge> rim;
        for (const mesh::TetFace& face : boundary) {
            std::vector<Edge> shared;
            for (const Edge& edge : face_edges(mesh, face))
                if (lip_edges.contains(edge))
                    shared.push_back(edge);
            if (!shared.empty() && !lip_keys.contains(face_key(mesh, face)) && faces_blade(mesh, face, blade))
                rim.insert(shared.begin(), shared.end());
        }
        return rim;
    }

    struct RimPoint {
        VertexId vertex = 0;
        double along = 0.0, depth = 0.0;
    };
    using Chain = std::vector<RimPoint>;

    /// The shortest path (in edges) through a connected rim from its first to its last point along the blade.
    Chain walk(const std::map<VertexId, std::vector<VertexId>>& next, const std::map<VertexId, RimPoint>& at,
        const std::vector<VertexId>& piece)
    {
        const auto before = [&](VertexId a, VertexId b) { return at.at(a).along < at.at(b).along; };
        const VertexId first = *std::min_element(piece.begin(), piece.end(), before);
        const VertexId last = *std::max_element(piece.begin(), piece.end(), before);
        std::map<VertexId, VertexId> came_from { { last, last } };
        std::queue<VertexId> queue({ last });
        while (!queue.empty() && !came_from.contains(first)) {
            const VertexId v = queue.front();
            queue.pop();
            for (const VertexId n : next.at(v))
                if (came_from.emplace(n, v).second)
                    queue.push(n);
        }
        Chain chain { at.at(first) };
        for (VertexId v = first; v != last;) {
            v = came_from.at(v);
            chain.push_back(at.at(v));
        }
        return chain;
    }

    std::vector<Chain> rim_chains(const std::set<Edge>& rim, const mesh::TetMesh& mesh, const mesh::SweptBlade& blade)
    {
        std::map<VertexId, std::vector<VertexId>> next;
        std::map<VertexId, RimPoint> at;
        for (const Edge& edge : rim)
            for (std::size_t end = 0; end < 2; ++end) {
                next[edge[end]].push_back(edge[1 - end]);
                if (!at.contains(edge[end])) {
                    const mesh::BladeCoordinates c = blade.coordinates(point_at(mesh.vertices, edge[end]));
                    at[edge[end]] = { edge[end], c.along, c.depth };
                }
            }
        std::vector<Chain> chains;
        std::set<VertexId> done;
        for (const auto& [start, unused] : next) {
            if (done.contains(start))
                continue;
            std::vector<VertexId> piece { start };
            done.insert(start);
            for (std::size_t i = 0; i < piece.size(); ++i)
                for (const VertexId n : next.at(piece[i]))
                    if (done.insert(n).second)
                        piece.push_back(n);
            chains.push_back(walk(next, at, piece));
        }
        return chains;
    }

    double mean_depth(const Chain& chain)
    {
        RETRACTOR_ASSERT(!chain.empty());
        double sum = 0.0;
        for (const RimPoint& p : chain)
            sum += p.depth;
        return sum / static_cast<double>(chain.size());
    }

    double extent(const Chain& chain) { return chain.back().along - chain.front().along; }

    /// Whether one chain lies above or below the other. Parts of one skin's edge may overlap a little where the skin is
    /// steep; they are stacked only where the overlap is most of the shorter one.
    /// @param skin mean depth below which chains are of one skin
    bool are_stacked(const Chain& a, const Chain& b, double skin)
    {
        const double overlap = std::min(a.back().along, b.back().along) - std::max(a.front().along, b.front().along);
        const bool of_one_skin = mean_depth(a) < skin && mean_depth(b) < skin;
        return overlap > (of_one_skin ? 0.5 * std::min(extent(a), extent(b)) : 0.0);
    }

    /// Keeps the shallowest of chains that lie above each other, and joins the kept chains from start to end. Chains at
    /// nearly the depth of the shallowest are of one skin: of these the longest are kept, so that a shard of skin
    /// beside or above the edge does not stand for it.
    WoundEdge shallowest(std::vector<Chain> chains)
    {
        RETRACTOR_ASSERT(!chains.empty());
        std::vector<double> depths;
        for (const Chain& chain : chains)
            depths.push_back(mean_depth(chain));
        const double skin = *std::min_element(depths.begin(), depths.end()) + kOneSkinMm;
        std::sort(chains.begin(), chains.end(), [&](const Chain& a, const Chain& b) {
            const double at_a = mean_depth(a), at_b = mean_depth(b);
            if (at_a < skin && at_b < skin)
                return extent(a) > extent(b);
            return at_a < at_b;
        });
        std::vector<Chain> kept;
        for (Chain& chain : chains)
            if (std::none_of(kept.begin(), kept.end(), [&](const Chain& k) { return are_stacked(chain, k, skin); }))
                kept.push_back(std::move(chain));
        std::sort(
            kept.begin(), kept.end(), [](const Chain& a, const Chain& b) { return a.front().along < b.front().along; });
        WoundEdge edge;
        for (const Chain& chain : kept) {
            // Where two parts overlap, the later one begins behind the earlier one's end.
            const double joined_at
                = edge.along_mm.empty() ? -std::numeric_limits<double>::infinity() : edge.along_mm.back();
            bool joined = false;
            for (const RimPoint& p : chain) {
                joined = joined || p.along > joined_at;
                if (!joined || (!edge.vertices.empty() && edge.vertices.back() == p.vertex))
                    continue;
                edge.vertices.push_back(p.vertex);
                // The parameter never decreases, even where the edge runs backwards on steep skin.
                edge.along_mm.push_back(edge.along_mm.empty() ? p.along : std::max(p.along, edge.along_mm.back()));
            }
        }
        return edge;
    }

    Vec3 blade_outward(const mesh::TetMesh& mesh, const std::set<Edge>& rim, const mesh::SweptBlade& blade)
    {
        Vec3 sum = Vec3::Zero();
        for (const Edge& edge : rim) {
            const Vec3 a = point_at(mesh.vertices, edge[0]), b = point_at(mesh.vertices, edge[1]);
            const Vec3 middle = 0.5 * (a + b);
            Vec3 gradient;
            for (int axis = 0; axis < 3; ++axis) {
                const Vec3 step = kDepthStep * Vec3::Unit(axis);
                gradient[axis] = blade.coordinates(middle - step).depth - blade.coordinates(middle + step).depth;
            }
            sum += (b - a).norm() * gradient;
        }
        return sum.normalized();
    }

    // ---- measuring it ---------------------------------------------------------------------------------

    double polyline_length(const std::vector<Vec3>& points)
    {
        double length = 0.0;
        for (std::size_t i = 1; i < points.size(); ++i)
            length += (points[i] - points[i - 1]).norm();
        return length;
    }

    void check_line(const LipLine& line, const char* name)
    {
        const std::string where = std::string(name) + " lip";
        if (line.points.size() < 2)
            throw InputError("a lip's edge needs at least two points", where);
        if (line.points.size() != line.along_mm.size())
            throw InputError("a lip's edge needs one parameter per point", where);
        for (std::size_t i = 0; i < line.points.size(); ++i) {
            if (!line.points[i].allFinite() || !std::isfinite(line.along_mm[i]))
                throw InputError("a lip's edge has a value that is not finite", where + ", point " + std::to_string(i));
            if (i > 0 && line.along_mm[i] < line.along_mm[i - 1])
                throw InputError("a lip's parameter runs backwards", where + ", point " + std::to_string(i));
        }
        if (!(polyline_length(line.points) > 0.0))
            throw InputError("a lip's edge has no length", where);
    }

    /// The point of a lip at a parameter; beyond an end, this end.
    Vec3 at(const LipLine& line, double along)
    {
        RETRACTOR_ASSERT(!line.points.empty() && line.points.size() == line.along_mm.size());
        const auto upper = std::upper_bound(line.along_mm.begin(), line.along_mm.end(), along);
        if (upper == line.along_mm.begin())
            return line.points.front();
        if (upper == line.along_mm.end())
            return line.points.back();
        const auto i = static_cast<std::size_t>(upper - line.along_mm.begin());
        const double t = (along - line.along_mm[i - 1]) / (line.along_mm[i] - line.along_mm[i - 1]);
        return line.points[i - 1] + t * (line.points[i] - line.points[i - 1]);
    }

    Vec3 loop_area_vector(const std::vector<Vec3>& loop)
    {
        Vec3 area = Vec3::Zero();
        for (std::size_t i = 0; i < loop.size(); ++i)
            area += area_vector(loop[0], loop[i], loop[(i + 1) % loop.size()]);
        return area;
    }

    /// A point of the line half way between the lips, and the pair of lip points that lay together before the cut.
    struct Rung {
        Vec3 left, right, middle;
    };

    std::vector<Rung> rungs(const LipLine& left, const LipLine& right)
    {
        std::vector<double> along = left.along_mm;
        along.insert(along.end(), right.along_mm.begin(), right.along_mm.end());
        std::sort(along.begin(), along.end());
        along.erase(std::unique(along.begin(), along.end()), along.end());
        std::vector<Rung> out;
        for (const double a : along) {
            const Vec3 l = at(left, a), r = at(right, a);
            out.push_back({ l, r, 0.5 * (l + r) });
        }
        return out;
    }

    /// The gap across the field at a rung: the part of left - right that is in the plane and at right angles to the
    /// middle line.
    double gap(const std::vector<Rung>& ladder, std::size_t i, const Vec3& normal, const Vec3& along)
    {
        Vec3 tangent = ladder[std::min(i + 1, ladder.size() - 1)].middle - ladder[i > 0 ? i - 1 : 0].middle;
        tangent -= normal * normal.dot(tangent);
        if (!(tangent.norm() > 0.0))
            tangent = along;
        return normal.cross(tangent.normalized()).dot(ladder[i].left - ladder[i].right);
    }

    void measure_width(OpeningGeometry& opening, const std::vector<Rung>& ladder)
    {
        RETRACTOR_ASSERT(!ladder.empty());
        std::vector<double> gaps;
        for (std::size_t i = 0; i < ladder.size(); ++i) {
            gaps.push_back(std::max(0.0, gap(ladder, i, opening.normal, opening.along)));
            opening.width_mm = std::max(opening.width_mm, gaps.back());
        }
        const bool closed = opening.area_mm2 <= kClosedArea * opening.length_mm * opening.length_mm;
        Vec3 sum = Vec3::Zero();
        double weight = 0.0;
        for (std::size_t i = 1; i < ladder.size(); ++i) {
            const double w
                = (ladder[i].middle - ladder[i - 1].middle).norm() * (closed ? 1.0 : 0.5 * (gaps[i] + gaps[i - 1]));
            sum += 0.5 * w * (ladder[i].middle + ladder[i - 1].middle);
            weight += w;
        }
        opening.centre = weight > 0.0 ? Vec3(sum / weight) : ladder[ladder.size() / 2].middle;
    }

    LipLine line_of(const WoundEdge& edge, const mesh::TetMesh& mesh, const Points& displacement)
    {
        RETRACTOR_ASSERT(edge.vertices.size() == edge.along_mm.size());
        LipLine line { {}, edge.along_mm };
        for (const VertexId v : edge.vertices) {
            if (v < 0 || v >= mesh.vertices.rows())
                throw InputError(
                    "the wound's edge uses a vertex that the mesh does not have", "vertex " + std::to_string(v));
            Vec3 p = point_at(mesh.vertices, v);
            if (displacement.rows() > 0)
                p += point_at(displacement, v);
            line.points.push_back(p);
        }
        return line;
    }

} // namespace

bool faces_blade(const mesh::TetMesh& mesh, const mesh::TetFace& face, const mesh::SweptBlade& blade)
{
    return rise(mesh, face, blade) > kFacesBlade;
}

WoundEdges wound_edges(const mesh::TetMesh& mesh, std::span<const mesh::LipFace> lips, const mesh::SweptBlade& blade)
{
    std::set<FaceKey> lip_keys;
    for (const mesh::LipFace& lip : lips) {
        if (lip.face.tet < 0 || static_cast<std::size_t>(lip.face.tet) >= mesh.tet_count() || lip.face.corner < 0
            || lip.face.corner > 3)
            throw InputError("a lip face is not a face of the mesh", "element " + std::to_string(lip.face.tet));
        lip_keys.insert(face_key(mesh, lip.face));
    }
    const std::vector<mesh::TetFace> boundary = mesh::boundary_faces(mesh);
    WoundEdges edges;
    std::set<Edge> both;
    for (const int side : { +1, -1 }) {
        const std::set<Edge> rim = skin_rim(mesh, lips, side, lip_keys, boundary, blade);
        if (rim.empty())
            throw InputError("the wound has no edge on the skin", side > 0 ? "left lip" : "right lip");
        (side > 0 ? edges.left : edges.right) = shallowest(rim_chains(rim, mesh, blade));
        both.insert(rim.begin(), rim.end());
    }
    edges.outward = blade_outward(mesh, both, blade);
    return edges;
}

OpeningGeometry opening_geometry(const LipLine& left, const LipLine& right, const Vec3& outward)
{
    check_line(left, "left");
    check_line(right, "right");
    if (!outward.allFinite() || !(outward.norm() > 0.0))
        throw InputError("the outward direction of an opening must be finite and not zero");
    OpeningGeometry opening;
    std::vector<Vec3> loop = right.points;
    loop.insert(loop.end(), left.points.rbegin(), left.points.rend());
    opening.incision_length_mm = 0.5 * (polyline_length(left.points) + polyline_length(right.points));

    const std::vector<Rung> ladder = rungs(left, right);
    opening.start = ladder.front().middle;
    opening.end = ladder.back().middle;
    Vec3 along = opening.end - opening.start;
    opening.length_mm = along.norm();
    if (!(opening.length_mm > 0.0))
        throw InputError("an opening's two ends must not coincide");

    const Vec3 area = loop_area_vector(loop);
    const bool closed = area.norm() <= kClosedArea * opening.length_mm * opening.length_mm;
    const double sign = area.dot(outward) < 0.0 ? -1.0 : 1.0;
    opening.normal = closed ? Vec3(outward.normalized()) : Vec3(sign * area.normalized());
    (sign > 0.0 ? opening.area_mm2 : opening.overlap_area_mm2) = area.norm();
    along -= opening.normal * opening.normal.dot(along);
    opening.along = along.norm() > 0.0 ? Vec3(along.normalized()) : opening.normal.unitOrthogonal();
    measure_width(opening, ladder);
    return opening;
}

OpeningGeometry opening_geometry(const WoundEdges& edges, const mesh::TetMesh& mesh, const Points& displacement)
{
    if (displacement.rows() > 0 && displacement.rows() != mesh.vertices.rows())
        throw InputError("the displacement has " + std::to_string(displacement.rows()) + " rows, the mesh "
            + std::to_string(mesh.vertices.rows()) + " vertices");
    OpeningGeometry opening = opening_geometry(
        line_of(edges.left, mesh, displacement), line_of(edges.right, mesh, displacement), edges.outward);
    opening.incision_length_mm = 0.5
        * (polyline_length(line_of(edges.left, mesh, {}).points)
            + polyline_length(line_of(edges.right, mesh, {}).points));
    return opening;
}

OpeningFromTarget opening_from(
    const OpeningGeometry& opening, const LipLine& left, const LipLine& right, const Vec3& from)
{
    OpeningFromTarget seen;
    const Vec3 to_centre = opening.centre - from;
    const double depth = to_centre.dot(opening.normal);
    seen.offset_mm = (to_centre - depth * opening.normal).norm();
    if (!(depth > 0.0) || opening.overlap_area_mm2 > 0.0)
        return seen;
    std::vector<Vec3> loop = right.points;
    loop.insert(loop.end(), left.points.rbegin(), left.points.rend());

    double solid_angle = 0.0;
    const Vec3 a = to_centre.normalized();
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Vec3 b = (loop[i] - from).normalized(), c = (loop[(i + 1) % loop.size()] - from).normalized();
        solid_angle += 2.0 * std::atan2(a.dot(b.cross(c)), 1.0 + a.dot(b) + b.dot(c) + c.dot(a));
    }
    seen.solid_angle_sr = std::abs(solid_angle);

    const Vec3 along = (opening.along - a * a.dot(opening.along)).normalized(), across = a.cross(along);
    const auto spread_deg = [&](const Vec3& axis) {
        double least = 0.0, most = 0.0; // rad, from the line to the centre
        for (const Vec3& p : loop) {
            const double angle = std::atan2((p - from).dot(axis), (p - from).dot(a));
            least = std::min(least, angle);
            most = std::max(most, angle);
        }
        return (most - least) * 180.0 / std::numbers::pi;
    };
    seen.along_deg = spread_deg(along);
    seen.across_deg = spread_deg(across);
    return seen;
}

OpeningFromTarget opening_from(const OpeningGeometry& opening, const WoundEdges& edges, const mesh::TetMesh& mesh,
    const Points& displacement, const Vec3& from)
{
    return opening_from(
        opening, line_of(edges.left, mesh, displacement), line_of(edges.right, mesh, displacement), from);
}

std::optional<double> working_distance_mm(
    const OpeningGeometry& opening, const TriMesh& target, const Vec3& aim, const Vec3& axis)
{
    constexpr double kParallel = 0.052; // sine of 3 degrees
    const Vec3 out = axis.normalized();
    const double cosine = out.dot(opening.normal);
    if (!(std::abs(cosine) > kParallel))
        return std::nullopt;
    const double skin = opening.normal.dot(opening.centre - aim) / cosine; // mm along the axis, from the aim
    double surface = -std::numeric_limits<double>::infinity();
    for (const auto& t : target.triangles)
        if (const auto hit = line_hit(aim, out, triangle_corners(target.vertices, t)))
            surface = std::max(surface, hit->distance);
    return skin - (std::isfinite(surface) ? surface : 0.0);
}

Vec3 surface_centre(const TriMesh& surface)
{
    Vec3 sum = Vec3::Zero();
    double area = 0.0;
    for (const auto& t : surface.triangles) {
        const auto [a, b, c] = triangle_corners(surface.vertices, t);
        const double w = triangle_area(a, b, c);
        sum += w * (a + b + c) / 3.0;
        area += w;
    }
    if (!(area > 0.0))
        throw InputError("a surface without area has no centre");
    return sum / area;
}

ViewCone cone_through_opening(
    const OpeningGeometry& opening, const Vec3& aim, double eye_distance_mm, double half_angle_deg, int eyes)
{
    const Vec3 axis = opening.centre - aim;
    if (!(axis.norm() > 0.0))
        throw InputError("the aim lies in the middle of the opening: there is no direction to look from");
    return { .aim = aim,
        .axis = axis.normalized(),
        .up = opening.along,
        .eye_distance_mm = eye_distance_mm,
        .half_angle_deg = half_angle_deg,
        .eyes = eyes };
}

} // namespace retractor::planner
