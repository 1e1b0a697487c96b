#include "fem/model/contact.h"

#include "fem/linear_algebra/parallel.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"
#include "mesh/surface/proximity.h"

#include <Eigen/Dense>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace retractor::fem {

namespace {

    // largest cosine between the normals of a point and of a face that look towards each other
    constexpr double kOpposed = -0.2;
    constexpr double kInside = -0.1; // least barycentric coordinate of a point above or below a face
    constexpr double kThin = 0.5; // in edges: at rest, a point farther behind a face is on the other side of a sheet

    Mat3 cross_matrix(const Vec3& a)
    {
        Mat3 m;
        m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
        return m;
    }

    /// Barycentric coordinates of the point's projection onto the face's plane.
    Vec3 plane_barycentric(const Vec3& point, const std::array<Vec3, 3>& face)
    {
        const Vec3 b = face[1] - face[0], c = face[2] - face[0], w = point - face[0], n = b.cross(c);
        const double squared = n.squaredNorm();
        const double v = w.cross(c).dot(n) / squared, u = b.cross(w).dot(n) / squared;
        return { 1.0 - v - u, v, u };
    }

    /// The vertex of a surface behind a number of ContactPair::node.
    VertexId vertex_of(std::int32_t node) { return node < 0 ? ~node : node; }

    bool faces_point(const Vec3& point, const std::array<Vec3, 3>& face)
    {
        return plane_barycentric(point, face).minCoeff() >= kInside;
    }

    double signed_distance(const Vec3& point, const std::array<Vec3, 3>& face)
    {
        return (point - face[0]).dot(unit_normal(face));
    }

    /// The triangles between the nodes of the boundary.
    std::vector<std::array<VertexId, 3>> boundary_triangles(const mesh::TetMesh& mesh)
    {
        std::vector<std::array<VertexId, 3>> triangles;
        for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
            const auto of_face = mesh::face_triangles(mesh, face);
            triangles.insert(triangles.end(), of_face.begin(), of_face.end());
        }
        return triangles;
    }

    /// A point that slides round a fold or an edge may lie deep behind a face that it was never in front of. The
    /// force must not jump there: the pair starts with the point's depth behind its previous face, and the rest of
    /// the overlap is kept without a force.
    void keep_smooth(ContactPair& pair, double distance, const ContactPair* before, const Points& points_at,
        const Points& faces_at, double edge)
    {
        constexpr double kJump = 0.1; // in edges: neighbouring faces of one surface differ by less
        if (before != nullptr && before->node == pair.node) {
            pair.overlap = before->overlap;
            return;
        }
        double held = 0.0;
        if (before != nullptr) {
            const Vec3 point = points_at.row(vertex_of(before->node[0])).transpose();
            const std::array<Vec3, 3> face = triangle_corners(
                faces_at, { vertex_of(before->node[1]), vertex_of(before->node[2]), vertex_of(before->node[3]) });
            held = std::min(signed_distance(point, face) - before->overlap, 0.0);
        }
        if (distance - pair.overlap < held - kJump * edge)
            pair.overlap = distance - held;
    }

} // namespace

PlaneDistance plane_distance(const Vec3& point, const std::array<Vec3, 3>& face)
{
    // s = V / N with V = w . (b x c), N = |b x c|, in w = point - a, b and c the face's edges from a.
    using Vec9 = Eigen::Matrix<double, 9, 1>;
    using Mat9 = Eigen::Matrix<double, 9, 9>;
    const Vec3 w = point - face[0], b = face[1] - face[0], c = face[2] - face[0], m = b.cross(c);
    const double N = m.norm(), V = w.dot(m);
    const Vec3 n = m / N;
    Vec9 dV, dN;
    dV << m, c.cross(w), w.cross(b);
    dN << Vec3::Zero(), c.cross(n), n.cross(b);
    Mat9 ddV = Mat9::Zero(), ddN = Mat9::Zero();
    ddV.block<3, 3>(0, 3) = -cross_matrix(c);
    ddV.block<3, 3>(0, 6) = cross_matrix(b);
    ddV.block<3, 3>(3, 6) = -cross_matrix(w);
    Eigen::Matrix<double, 3, 9> dm;
    dm << Mat3::Zero(), -cross_matrix(c), cross_matrix(b);
    ddN = dm.transpose() * (Mat3::Identity() - n * n.transpose()) * dm / N;
    ddN.block<3, 3>(3, 6) -= cross_matrix(n);
    ddN.block<3, 3>(6, 3) += cross_matrix(n);
    ddV.block<3, 3>(3, 0) = ddV.block<3, 3>(0, 3).transpose();
    ddV.block<3, 3>(6, 0) = ddV.block<3, 3>(0, 6).transpose();
    ddV.block<3, 3>(6, 3) = ddV.block<3, 3>(3, 6).transpose();
    const Vec9 d = dV / N - V * dN / (N * N);
    const Mat9 dd = ddV / N - (dV * dN.transpose() + dN * dV.transpose()) / (N * N) - V * ddN / (N * N)
        + 2.0 * V * dN * dN.transpose() / (N * N * N);
    Eigen::Matrix<double, 9, 12> to = Eigen::Matrix<double, 9, 12>::Zero(); // derivative of w, b, c by the four points
    for (int i = 0; i < 3; ++i) {
        to.block<3, 3>(3 * i, 3) = -Mat3::Identity();
        to.block<3, 3>(3 * i, i == 0 ? 0 : 3 + 3 * i) = Mat3::Identity();
    }
    return { V / N, to.transpose() * d, to.transpose() * dd * to };
}

Contact::Surface Contact::surface_of(Points rest, Triangles triangles)
{
    Surface s { std::move(rest), std::move(triangles), {}, {}, {}, {} };
    const auto n = static_cast<std::size_t>(s.rest.rows());
    s.around.resize(n);
    s.overlap_self.assign(n, 0.0);
    s.overlap_other.assign(n, 0.0);
    for (std::size_t t = 0; t < s.triangles.size(); ++t)
        for (const VertexId v : s.triangles[t])
            s.around[static_cast<std::size_t>(v)].push_back(static_cast<std::int32_t>(t));
    for (std::size_t v = 0; v < n; ++v)
        if (!s.around[v].empty())
            s.points.push_back(static_cast<VertexId>(v));
    return s;
}

Points Contact::Surface::normals(const Points& at) const
{
    Points normal = Points::Zero(at.rows(), 3);
    for (const auto& triangle : triangles) {
        const Vec3 n = area_vector(at, triangle);
        for (const VertexId v : triangle)
            normal.row(v) += n.transpose();
    }
    for (const VertexId v : points) { // at the bottom of a wound the two lips meet: no normal there, and no contact
        constexpr double kFlat = 1e-6;
        const double length = normal.row(v).norm();
        double all = 0.0;
        for (const std::int32_t t : around[static_cast<std::size_t>(v)])
            all += triangle_area(at, triangles[static_cast<std::size_t>(t)]);
        if (length > kFlat * all)
            normal.row(v) /= length;
        else
            normal.row(v).setZero();
    }
    return normal;
}

double Contact::Surface::area_towards(VertexId point, const Points& at, const Vec3& direction) const
{
    RETRACTOR_ASSERT(point >= 0 && static_cast<std::size_t>(point) < around.size());
    double area = 0.0;
    for (const std::int32_t t : around[static_cast<std::size_t>(point)]) {
        const auto& triangle = triangles[static_cast<std::size_t>(t)];
        const double towards = unit_normal(at, triangle).dot(direction);
        area += std::max(towards, 0.0) * triangle_area(rest, triangle) / 3.0;
    }
    return area;
}

Contact::Contact(const mesh::TetMesh& mesh, const std::vector<Lame>& lame, ContactOptions options)
    : options_(std::move(options))
{
    if (!(options_.stiffness > 0.0 && std::isfinite(options_.stiffness) && options_.stiffest_N_mm3 > 0.0
            && options_.reach > 0.0 && std::isfinite(options_.reach)))
        throw InputError("the penalty's stiffness and the reach must be positive", "contact");
    if (lame.size() != mesh.tet_count())
        throw InputError("contact needs the parameters of each element", "contact");
    body_ = surface_of(mesh.vertices, boundary_triangles(mesh));
    Triangles triangles;
    for (std::size_t s = 0; s < options_.fixed.size(); ++s)
        for (std::size_t t = 0; t < options_.fixed[s].triangles.size(); ++t) {
            const TriMesh& surface = options_.fixed[s];
            const std::string where = "fixed surface " + std::to_string(s) + ", triangle " + std::to_string(t);
            for (const VertexId v : surface.triangles[t])
                if (v < 0 || v >= surface.vertices.rows() || !surface.vertices.row(v).allFinite())
                    throw InputError("vertex " + std::to_string(v) + " is out of range or not finite", where);
            if (!(triangle_area(surface.vertices, surface.triangles[t]) > 0.0))
                throw InputError("the triangle has no area", where);
        }
    Points fixed(0, 3);
    for (const TriMesh& surface : options_.fixed) {
        const auto before = static_cast<VertexId>(fixed.rows());
        fixed.conservativeResize(before + surface.vertices.rows(), 3);
        fixed.bottomRows(surface.vertices.rows()) = surface.vertices;
        for (const auto& t : surface.triangles)
            triangles.push_back({ t[0] + before, t[1] + before, t[2] + before });
        fixed_end_.push_back(static_cast<VertexId>(fixed.rows()));
    }
    options_.fixed.clear(); // the surfaces are kept in fixed_ only
    fixed_ = surface_of(std::move(fixed), std::move(triangles));
    near_body_.emplace(body_.rest, body_.triangles);
    near_fixed_.emplace(fixed_.rest, fixed_.triangles);
    fixed_normals_ = fixed_.normals(fixed_.rest);

    modulus_per_edge_.assign(mesh.vertex_count(), 0.0);
    edge_.assign(mesh.vertex_count(), 0.0);
    std::vector<int> around(mesh.vertex_count(), 0);
    for (std::size_t t = 0; t < mesh.tet_count(); ++t)
        for (const VertexId v : mesh.tet(static_cast<TetId>(t))) {
            modulus_per_edge_[static_cast<std::size_t>(v)] += lame[t].lambda + 2.0 * lame[t].mu;
            ++around[static_cast<std::size_t>(v)];
        }
    for (const VertexId v : body_.points) {
        const auto i = static_cast<std::size_t>(v);
        // leg of a right isosceles triangle with the area of the triangles here
        for (const std::int32_t t : body_.around[i])
            edge_[i] += 2.0 * triangle_area(body_.rest, body_.triangles[static_cast<std::size_t>(t)])
                / static_cast<double>(body_.around[i].size());
        edge_[i] = std::sqrt(edge_[i]);
        modulus_per_edge_[i] /= around[i] * edge_[i];
    }
    note_overlaps();
}

Points Contact::positions(const Eigen::VectorXd& u) const
{
    RETRACTOR_ASSERT(u.size() == 3 * body_.rest.rows());
    return body_.rest + Eigen::Map<const Points>(u.data(), body_.rest.rows(), 3);
}

Vec3 Contact::place(const Eigen::VectorXd& u, std::int32_t node) const
{
    if (node < 0)
        return fixed_.rest.row(~node).transpose();
    return body_.rest.row(node).transpose() + u.segment<3>(3 * static_cast<Eigen::Index>(node));
}

std::array<Vec3, 4> Contact::corners(const Eigen::VectorXd& u, const ContactPair& pair) const
{
    return { place(u, pair.node[0]), place(u, pair.node[1]), place(u, pair.node[2]), place(u, pair.node[3]) };
}

double Contact::edge_at(const Side& points, VertexId point, const std::array<VertexId, 3>& triangle) const
{
    return edge_[static_cast<std::size_t>(points.of_body ? point : triangle[0])];
}

/// Appends the best face of each point to `pairs`, in the order of the points.
void Contact::pair_points(const Side& points, const Side& faces, Pairing pairing, std::vector<ContactPair>& pairs) const
{
    RETRACTOR_ASSERT(points.of_body || faces.of_body);
    const std::vector<VertexId>& vertices = points.surface.points;
    std::vector<const ContactPair*> before(points.surface.around.size()); // by vertex
    for (const ContactPair& pair : pairs_)
        if ((pair.node[0] >= 0) == points.of_body && (pair.node[1] >= 0) == faces.of_body)
            before[static_cast<std::size_t>(vertex_of(pair.node[0]))] = &pair;
    const bool self = points.of_body && faces.of_body;
    const std::vector<double>& overlap = self ? points.surface.overlap_self : points.surface.overlap_other;
    std::vector<std::optional<ContactPair>> found(vertices.size());
    parallel_halves(vertices.size(), [&](std::size_t half, std::size_t begin, std::size_t end) {
        for (std::size_t k = 0; k < end - begin; ++k) { // every other point: most lie close together near the wound
            const std::size_t i = 2 * k + 1 - half; // the first half is the smaller one
            RETRACTOR_ASSERT(i < vertices.size());
            const VertexId v = vertices[i];
            const ContactPair* known = before[static_cast<std::size_t>(v)];
            if (pairing == Pairing::new_only && known != nullptr) {
                found[i] = *known;
                continue;
            }
            const Seeker seeker { v, points.at.row(v).transpose(), points.normals.row(v).transpose(),
                overlap[static_cast<std::size_t>(v)], known };
            if (const auto best = best_face(points, faces, seeker))
                found[i] = make_pair(points, faces, seeker, *best);
        }
    });
    for (const std::optional<ContactPair>& pair : found)
        if (pair)
            pairs.push_back(*pair);
}

/// The nearest face that the point can meet; the face of its last pair where this face is about as near.
std::optional<std::array<VertexId, 3>> Contact::best_face(
    const Side& points, const Side& faces, const Seeker& seeker) const
{
    constexpr double kAsGood = 1.25, kRoundOffMm = 1e-9;
    const auto can_take = [&](const std::array<VertexId, 3>& face) {
        return !is_adjacent(points, faces, seeker.vertex, face) && can_meet(points, faces, seeker, face);
    };
    std::array<VertexId, 3> last {};
    double last_distance = options_.reach;
    bool keeps = false; // whether the point can keep the face of its last pair
    if (seeker.before != nullptr) {
        const auto& node = seeker.before->node;
        last = { vertex_of(node[1]), vertex_of(node[2]), vertex_of(node[3]) };
        const std::array<Vec3, 3> face = triangle_corners(faces.at, last);
        const double distance = mesh::closest_on_triangle(seeker.place, face[0], face[1], face[2]).distance;
        keeps = distance <= options_.reach && seeker.normal.dot(unit_normal(face)) < kOpposed && can_take(last);
        if (keeps)
            last_distance = distance;
    }
    const std::vector<std::array<VertexId, 3>>& triangles = faces.surface.triangles;
    const auto nearest = faces.near.nearest({ seeker.place, last_distance, seeker.normal, kOpposed },
        [&](std::int32_t triangle) { return can_take(triangles[static_cast<std::size_t>(triangle)]); });
    if (keeps && (!nearest || last_distance <= kAsGood * nearest->distance + kRoundOffMm))
        return last;
    return nearest ? std::optional(triangles[static_cast<std::size_t>(nearest->triangle)]) : std::nullopt;
}

/// Whether a face shares a corner with the faces round the point: where tissue folds at the rim of a hook's patch, the
/// faces next to a point look towards it.
bool Contact::is_adjacent(
    const Side& points, const Side& faces, VertexId point, const std::array<VertexId, 3>& face) const
{
    if (!points.of_body || !faces.of_body)
        return false;
    const std::vector<std::int32_t>& around = points.surface.around[static_cast<std::size_t>(point)];
    return std::any_of(around.begin(), around.end(), [&](std::int32_t t) {
        const auto& ring = points.surface.triangles[static_cast<std::size_t>(t)];
        return std::find_first_of(ring.begin(), ring.end(), face.begin(), face.end()) != ring.end();
    });
}

/// Whether the point lies over a face that looks towards it, and is not behind the face since rest.
bool Contact::can_meet(
    const Side& points, const Side& faces, const Seeker& seeker, const std::array<VertexId, 3>& triangle) const
{
    const std::array<Vec3, 3> face = triangle_corners(faces.at, triangle);
    if (!faces_point(seeker.place, face))
        return false;
    const std::array<Vec3, 3> face_at_rest = triangle_corners(faces.surface.rest, triangle);
    const Vec3 p_at_rest = points.surface.rest.row(seeker.vertex).transpose();
    if (signed_distance(p_at_rest, face_at_rest) < -kThin * edge_at(points, seeker.vertex, triangle)
        && mesh::closest_on_triangle(p_at_rest, face_at_rest[0], face_at_rest[1], face_at_rest[2]).distance
            < 2.0 * options_.reach)
        return false;
    // A point that was never near the face and lies deep behind it has been inside all along.
    return seeker.before != nullptr
        || !(signed_distance(seeker.place, face) - std::min(seeker.overlap, 0.0) < -0.5 * options_.reach);
}

ContactPair Contact::make_pair(
    const Side& points, const Side& faces, const Seeker& seeker, const std::array<VertexId, 3>& triangle) const
{
    const std::array<Vec3, 3> face = triangle_corners(faces.at, triangle);
    const Vec3 n = unit_normal(face);
    double area = points.surface.area_towards(seeker.vertex, points.at, -n), modulus = 0.0;
    if (points.of_body) {
        modulus = modulus_per_edge_[static_cast<std::size_t>(seeker.vertex)];
    } else {
        double face_area = 0.0;
        for (const VertexId corner : triangle) {
            modulus += modulus_per_edge_[static_cast<std::size_t>(corner)] / 3.0;
            face_area += faces.surface.area_towards(corner, faces.at, n) / 3.0;
        }
        area = std::min(area, face_area); // the points of a coarse surface have more area than they touch
    }
    ContactPair pair { { points.number(seeker.vertex), faces.number(triangle[0]), faces.number(triangle[1]),
                           faces.number(triangle[2]) },
        0.5 * std::min(options_.stiffness * modulus, options_.stiffest_N_mm3) * area, seeker.overlap };
    if (!pairs_.empty())
        keep_smooth(pair, signed_distance(seeker.place, face), seeker.before, points.at, faces.at,
            edge_at(points, seeker.vertex, triangle));
    return pair;
}

bool Contact::find(const Eigen::VectorXd& u, Pairing pairing)
{
    const Points at = positions(u);
    if (!at.allFinite())
        throw InputError("a displacement is not finite", "contact");
    near_body_->refit(at);
    std::vector<ContactPair> found;
    const Points normals = body_.normals(at);
    const Side body { body_, at, true, normals, *near_body_ },
        fixed { fixed_, fixed_.rest, false, fixed_normals_, *near_fixed_ };
    pair_points(body, body, pairing, found);
    if (!fixed_.triangles.empty()) {
        pair_points(body, fixed, pairing, found);
        pair_points(fixed, body, pairing, found);
    }
    const bool changed = found != pairs_;
    pairs_ = std::move(found);
    for (const ContactPair& pair : pairs_) // an overlap that was kept at a fold counts like an overlap at rest
        overlap_at_rest_ = std::max(overlap_at_rest_, -pair.overlap);
    return changed;
}

void Contact::follow(const Eigen::VectorXd& displacement)
{
    // A step moves two surfaces against each other by less than the reach. find() then sees each point in front of a
    // face before the point passes through; a point that is first seen behind a face counts as an overlap that is kept.
    constexpr double kStepsPerReach = 2.5;
    double farthest = 0.0;
    for (Eigen::Index i = 0; i < displacement.size(); i += 3)
        farthest = std::max(farthest, displacement.segment<3>(i).norm());
    const int steps = std::max(1, static_cast<int>(std::ceil(kStepsPerReach * farthest / options_.reach)));
    for (int step = 1; step <= steps; ++step)
        (void)find(static_cast<double>(step) / steps * displacement);
}

void Contact::note_overlaps()
{
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(3 * body_.rest.rows());
    (void)find(rest);
    for (const ContactPair& pair : pairs_) {
        const auto [p, a, b, c] = corners(rest, pair);
        const double s = std::min(signed_distance(p, { a, b, c }), 0.0);
        overlap_at_rest_ = std::max(overlap_at_rest_, -s);
        const bool of_body = pair.node[0] >= 0, self = of_body && pair.node[1] >= 0;
        Surface& surface = of_body ? body_ : fixed_;
        (self ? surface.overlap_self
              : surface.overlap_other)[static_cast<std::size_t>(of_body ? pair.node[0] : ~pair.node[0])]
            = s;
    }
    pairs_.clear();
}

double Contact::energy(const Eigen::VectorXd& u) const
{
    double energy = 0.0;
    for (const ContactPair& pair : pairs_) {
        const auto [p, a, b, c] = corners(u, pair);
        const double depth = std::min(signed_distance(p, { a, b, c }) - pair.overlap, 0.0);
        energy += 0.5 * pair.stiffness * depth * depth;
    }
    return energy;
}

double Contact::add_response(const Eigen::VectorXd& u, Eigen::VectorXd& forces) const
{
    for (const ContactPair& pair : pairs_) {
        const auto [p, a, b, c] = corners(u, pair);
        const double depth = signed_distance(p, { a, b, c }) - pair.overlap;
        if (!(depth < 0.0))
            continue;
        const PlaneDistance s = plane_distance(p, { a, b, c });
        for (int i = 0; i < 4; ++i)
            if (const std::int32_t node = pair.node[static_cast<std::size_t>(i)]; node >= 0)
                forces.segment<3>(3 * static_cast<Eigen::Index>(node))
                    += pair.stiffness * depth * s.gradient.segment<3>(3 * i);
    }
    return energy(u);
}

BlockPattern extended_pattern(const BlockPattern& body, std::vector<std::pair<std::int32_t, std::int32_t>> more)
{
    std::sort(more.begin(), more.end());
    more.erase(std::unique(more.begin(), more.end()), more.end());
    BlockPattern pattern;
    pattern.row_start.push_back(0);
    auto next = more.begin();
    for (std::size_t row = 0; row < body.row_count(); ++row) {
        const auto begin = static_cast<std::ptrdiff_t>(pattern.column.size());
        pattern.column.insert(pattern.column.end(), body.column.begin() + body.row_start[row],
            body.column.begin() + body.row_start[row + 1]);
        for (; next != more.end() && next->first == static_cast<std::int32_t>(row); ++next)
            pattern.column.push_back(next->second);
        std::sort(pattern.column.begin() + begin, pattern.column.end());
        pattern.column.erase(std::unique(pattern.column.begin() + begin, pattern.column.end()), pattern.column.end());
        pattern.row_start.push_back(static_cast<std::int32_t>(pattern.column.size()));
    }
    return pattern;
}

BlockPattern Contact::pattern(const BlockPattern& body) const
{
    std::vector<std::pair<std::int32_t, std::int32_t>> more; // additional entries: row and column
    for (const ContactPair& pair : pairs_)
        for (const std::int32_t row : pair.node)
            for (const std::int32_t column : pair.node)
                if (column >= 0 && row >= column)
                    more.emplace_back(row, column);
    return extended_pattern(body, std::move(more));
}

BlockPattern Contact::pattern_with_neighbours(const BlockPattern& body) const
{
    std::vector<std::pair<std::int32_t, std::int32_t>> more;
    for (const ContactPair& pair : pairs_) {
        if (pair.node[0] < 0 || pair.node[1] < 0) // one element holds all nodes, or there is only one node
            continue;
        for (std::size_t corner = 1; corner < pair.node.size(); ++corner)
            for (const std::int32_t t : body_.around[static_cast<std::size_t>(pair.node[corner])])
                for (const VertexId v : body_.triangles[static_cast<std::size_t>(t)])
                    more.emplace_back(std::max(v, pair.node[0]), std::min(v, pair.node[0]));
    }
    return extended_pattern(pattern(body), std::move(more));
}

bool Contact::is_within(const BlockPattern& pattern) const
{
    if (pattern.row_start.empty())
        return pairs_.empty();
    const auto has = [&](std::int32_t row, std::int32_t column) {
        const auto begin = pattern.column.begin() + pattern.row_start[static_cast<std::size_t>(row)];
        const auto end = pattern.column.begin() + pattern.row_start[static_cast<std::size_t>(row) + 1];
        return std::binary_search(begin, end, column);
    };
    return std::all_of(pairs_.begin(), pairs_.end(), [&](const ContactPair& pair) {
        for (const std::int32_t row : pair.node)
            for (const std::int32_t column : pair.node)
                if (column >= 0 && row >= column && !has(row, column))
                    return false;
        return true;
    });
}

void Contact::add_stiffness(const Eigen::VectorXd& u, double projected, BlockMatrix& matrix) const
{
    RETRACTOR_ASSERT(matrix.values.size() == 9 * matrix.pattern.block_count());
    const BlockPattern& pattern = matrix.pattern;
    for (const ContactPair& pair : pairs_) {
        const auto [p, a, b, c] = corners(u, pair);
        const double depth = signed_distance(p, { a, b, c }) - pair.overlap;
        if (!(depth < 0.0))
            continue;
        const PlaneDistance s = plane_distance(p, { a, b, c });
        const Eigen::Matrix<double, 12, 12> K
            = pair.stiffness * (s.gradient * s.gradient.transpose() + (1.0 - projected) * depth * s.hessian);
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) {
                const std::int32_t row = pair.node[static_cast<std::size_t>(i)],
                                   column = pair.node[static_cast<std::size_t>(j)];
                if (column < 0 || row < column)
                    continue;
                const auto begin = pattern.column.begin() + pattern.row_start[static_cast<std::size_t>(row)];
                const auto end = pattern.column.begin() + pattern.row_start[static_cast<std::size_t>(row) + 1];
                const auto block = std::lower_bound(begin, end, column) - pattern.column.begin();
                Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(
                    matrix.values.data() + 9 * static_cast<std::size_t>(block))
                    += K.block<3, 3>(3 * i, 3 * j);
            }
    }
}

std::optional<std::size_t> Contact::fixed_surface_of(const ContactPair& pair) const
{
    const std::int32_t node = std::min(pair.node[0], pair.node[1]);
    if (node >= 0)
        return std::nullopt;
    const auto surface = std::upper_bound(fixed_end_.begin(), fixed_end_.end(), ~node);
    RETRACTOR_ASSERT(surface != fixed_end_.end());
    return static_cast<std::size_t>(surface - fixed_end_.begin());
}

Contact::State Contact::state(const Eigen::VectorXd& u) const
{
    State state;
    for (const ContactPair& pair : pairs_) {
        const auto [p, a, b, c] = corners(u, pair);
        const double depth = signed_distance(p, { a, b, c }) - pair.overlap;
        if (!(depth < 0.0))
            continue;
        ++state.touching;
        state.force_N -= pair.stiffness * depth;
        if (-depth > state.penetration) {
            state.penetration = -depth;
            state.place = p;
            state.fixed = fixed_surface_of(pair);
        }
    }
    return state;
}

double Contact::free_share(
    const Eigen::VectorXd& u, const Eigen::VectorXd& motion, const std::vector<std::uint8_t>& prescribed) const
{
    RETRACTOR_ASSERT(u.size() == motion.size() && prescribed.size() == static_cast<std::size_t>(u.size()));
    constexpr double kAllowed = 0.01; // mm behind a face that are tolerated without a force
    constexpr int kHalvings = 20;
    double free = 1.0;
    for (const ContactPair& pair : pairs_) {
        if (std::any_of(pair.node.begin(), pair.node.end(),
                [&](std::int32_t node) { return node >= 0 && prescribed[3 * static_cast<std::size_t>(node)] == 0; }))
            continue;
        const std::array<Vec3, 4> from = corners(u, pair);
        const auto depth = [&](double share) {
            std::array<Vec3, 4> at = from;
            for (std::size_t i = 0; i < 4; ++i)
                if (pair.node[i] >= 0)
                    at[i] += share * motion.segment<3>(3 * static_cast<Eigen::Index>(pair.node[i]));
            const std::array<Vec3, 3> face { at[1], at[2], at[3] };
            return faces_point(at[0], face) ? signed_distance(at[0], face) - pair.overlap : 0.0;
        };
        const double limit = std::min(-kAllowed, depth(0.0));
        if (depth(free) >= limit)
            continue;
        double good = 0.0;
        for (int i = 0; i < kHalvings; ++i) {
            const double middle = 0.5 * (good + free);
            (depth(middle) >= limit ? good : free) = middle;
        }
        free = good;
    }
    return free;
}

} // namespace retractor::fem
