#include "fem/model/loads.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>

namespace retractor::fem {

namespace {

    using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

    /// Shape functions of a triangle with three or six nodes and their derivatives by its first two coordinates.
    struct FacePoint {
        std::array<double, 6> N {}, ds {}, dt {};
        double weight = 0.0; ///< weight for the reference triangle, whose area is 1/2
    };

    FacePoint face_point(bool quadratic, const std::array<double, 3>& l, double weight)
    {
        if (!quadratic)
            return { { l[0], l[1], l[2] }, { -1, 1, 0 }, { -1, 0, 1 }, 0.5 * weight };
        return { { l[0] * (2 * l[0] - 1), l[1] * (2 * l[1] - 1), l[2] * (2 * l[2] - 1), 4 * l[0] * l[1],
                     4 * l[1] * l[2], 4 * l[2] * l[0] },
            { 1 - 4 * l[0], 4 * l[1] - 1, 0, 4 * (l[0] - l[1]), 4 * l[2], -4 * l[2] },
            { 1 - 4 * l[0], 0, 4 * l[2] - 1, -4 * l[1], 4 * l[1], 4 * (l[0] - l[2]) }, 0.5 * weight };
    }

    /// Six points, exact for degree 4 [Dunavant 1985]: the product of three quadratic shape functions, two of them
    /// derived.
    std::array<FacePoint, 6> face_rule(bool quadratic)
    {
        constexpr double a = 0.445948490915965, b = 0.091576213509771, wa = 0.223381589678011, wb = 0.109951743655322;
        std::array<FacePoint, 6> rule;
        std::size_t i = 0;
        for (const auto& [v, w] : { std::pair { a, wa }, std::pair { b, wb } })
            for (std::size_t k = 0; k < 3; ++k) {
                std::array<double, 3> l { v, v, v };
                l[k] = 1 - 2 * v;
                rule[i++] = face_point(quadratic, l, w);
            }
        return rule;
    }

    /// Corners counter-clockwise seen from outside, then the midpoints between the corners.
    std::vector<VertexId> face_nodes(const mesh::TetMesh& mesh, const mesh::TetFace& face)
    {
        const auto nodes = mesh.tet(face.tet);
        const auto& corner = mesh::kTetFaces[static_cast<std::size_t>(face.corner)];
        std::vector<VertexId> all;
        for (const int c : corner)
            all.push_back(nodes[static_cast<std::size_t>(c)]);
        for (std::size_t i = 0; mesh.nodes_per_tet == 10 && i < 3; ++i)
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
                if (std::minmax(corner[i], corner[(i + 1) % 3])
                    == std::minmax(mesh::kTetEdges[e][0], mesh::kTetEdges[e][1]))
                    all.push_back(nodes[4 + e]);
        return all;
    }

    /// The same point on a face whose straight edges (tet_mesh.h) add half of their function to each of their ends.
    FacePoint on_face(FacePoint point, std::span<const VertexId> nodes)
    {
        for (std::size_t i = 0; nodes.size() == 6 && i < 3; ++i)
            if (const std::size_t j = (i + 1) % 3; nodes[3 + i] == nodes[i] || nodes[3 + i] == nodes[j])
                for (auto* of : { &point.N, &point.ds, &point.dt }) {
                    (*of)[i] += 0.5 * (*of)[3 + i];
                    (*of)[j] += 0.5 * (*of)[3 + i];
                    (*of)[3 + i] = 0.0;
                }
        return point;
    }

    void check_faces(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& faces)
    {
        if (faces.empty())
            throw InputError("a load needs at least one face", "load");
        std::set<std::pair<TetId, int>> boundary;
        for (const mesh::TetFace& face : mesh::boundary_faces(mesh))
            boundary.insert({ face.tet, face.corner });
        for (const mesh::TetFace& face : faces)
            if (!boundary.contains({ face.tet, face.corner }))
                throw InputError("a load acts on the surface; this face is inside or does not exist",
                    "element " + std::to_string(face.tet) + ", face " + std::to_string(face.corner));
    }

    RowMat3 cross_matrix(const Vec3& v)
    {
        RowMat3 m;
        m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
        return m;
    }

} // namespace

Eigen::VectorXd traction_loads(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& faces, const Vec3& traction)
{
    check_faces(mesh, faces);
    std::vector<FaceTraction> tractions;
    tractions.reserve(faces.size());
    for (const mesh::TetFace& face : faces)
        tractions.push_back({ face, traction });
    return traction_loads(mesh, tractions);
}

Eigen::VectorXd traction_loads(const mesh::TetMesh& mesh, std::span<const FaceTraction> tractions)
{
    Eigen::VectorXd loads = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
    const auto rule = face_rule(mesh.nodes_per_tet == 10);
    for (const auto& [face, traction] : tractions) {
        if (face.tet < 0 || static_cast<std::size_t>(face.tet) >= mesh.tet_count() || face.corner < 0
            || face.corner > 3)
            throw InputError("a load acts on a face that is not in the mesh", "element " + std::to_string(face.tet));
        if (!traction.allFinite())
            throw InputError("the traction is not finite", "load");
        const std::vector<VertexId> nodes = face_nodes(mesh, face);
        for (const FacePoint& reference : rule) {
            const FacePoint point = on_face(reference, nodes);
            Vec3 s = Vec3::Zero(), t = Vec3::Zero();
            for (std::size_t a = 0; a < nodes.size(); ++a) {
                s += point.ds[a] * mesh.vertices.row(nodes[a]).transpose();
                t += point.dt[a] * mesh.vertices.row(nodes[a]).transpose();
            }
            const double area = point.weight * s.cross(t).norm();
            for (std::size_t a = 0; a < nodes.size(); ++a)
                loads.segment<3>(3 * static_cast<Eigen::Index>(nodes[a])) += area * point.N[a] * traction;
        }
    }
    return loads;
}

namespace {

    /// Position or displacement at a point of a surface, with derivatives by the face's two coordinates.
    struct SurfacePoint {
        Vec3 x = Vec3::Zero(), s = Vec3::Zero(), t = Vec3::Zero();
    };

    struct SidePoint {
        std::array<double, 3> N {}, dN {};
        double weight = 0.0;
    };

    /// Shape functions of a side with two or three nodes. Gauss's rule with three points is exact for degree 5: the
    /// product of three quadratic shape functions, one of them derived.
    std::array<SidePoint, 3> side_rule(bool quadratic)
    {
        const double offset = std::sqrt(0.15);
        std::array<SidePoint, 3> rule;
        std::size_t i = 0;
        for (const auto& [s, weight] : { std::pair { 0.5 - offset, 5.0 / 18.0 }, std::pair { 0.5, 4.0 / 9.0 },
                 std::pair { 0.5 + offset, 5.0 / 18.0 } })
            rule[i++] = quadratic ? SidePoint { { (1 - s) * (1 - 2 * s), s * (2 * s - 1), 4 * s * (1 - s) },
                { 4 * s - 3, 4 * s - 1, 4 - 8 * s }, weight }
                                  : SidePoint { { 1 - s, s }, { -1, 1 }, weight };
        return rule;
    }

    /// As on_face().
    SidePoint on_side(SidePoint point, std::span<const VertexId> nodes)
    {
        if (nodes.size() == 3 && (nodes[2] == nodes[0] || nodes[2] == nodes[1]))
            for (auto* of : { &point.N, &point.dN }) {
                (*of)[0] += 0.5 * (*of)[2];
                (*of)[1] += 0.5 * (*of)[2];
                (*of)[2] = 0.0;
            }
        return point;
    }

    /// The nodes of the sides that belong to one face only, in the order of FollowerPressure::rim_.
    std::vector<VertexId> rim_of(const std::vector<VertexId>& nodes, std::size_t nodes_per_face)
    {
        std::map<std::pair<VertexId, VertexId>, std::vector<VertexId>> sides; // empty for a side of two faces
        for (std::size_t begin = 0; begin < nodes.size(); begin += nodes_per_face)
            for (std::size_t i = 0; i < 3; ++i) {
                const VertexId a = nodes[begin + i], b = nodes[begin + (i + 1) % 3];
                const auto [side, first] = sides.try_emplace(std::minmax(a, b));
                if (!first)
                    side->second.clear();
                else if (nodes_per_face == 6)
                    side->second = { a, b, nodes[begin + 3 + i] };
                else
                    side->second = { a, b };
            }
        std::vector<VertexId> rim;
        for (const auto& [ends, side] : sides)
            rim.insert(rim.end(), side.begin(), side.end());
        return rim;
    }

    /// @pre column < row, and the pattern couples them.
    Eigen::Map<RowMat3> lower_block(BlockMatrix& K, VertexId row, VertexId column)
    {
        const auto begin = K.pattern.column.begin() + K.pattern.row_start[static_cast<std::size_t>(row)];
        const auto end = K.pattern.column.begin() + K.pattern.row_start[static_cast<std::size_t>(row) + 1];
        return Eigen::Map<RowMat3>(
            K.values.data() + 9 * (std::lower_bound(begin, end, column) - K.pattern.column.begin()));
    }

} // namespace

FollowerPressure::FollowerPressure(const mesh::TetMesh& mesh, const std::vector<mesh::TetFace>& faces, double pressure)
    : rest_(mesh.vertices)
    , nodes_per_face_(mesh.nodes_per_tet == 10 ? 6 : 3)
    , pressure_(pressure)
{
    check_faces(mesh, faces);
    if (!std::isfinite(pressure))
        throw InputError("the pressure is not finite", "load");
    for (const mesh::TetFace& face : faces) {
        const std::vector<VertexId> nodes = face_nodes(mesh, face);
        nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
    }
    const Eigen::RowVector3d middle = rest_(nodes_, Eigen::all).colwise().mean();
    rest_.rowwise() -= middle;
    rim_ = rim_of(nodes_, nodes_per_face_);
    rim_at_ = Eigen::VectorXd::Zero(3 * rest_.rows());
}

void FollowerPressure::renew_rim(const Eigen::VectorXd& u) { rim_at_ = u; }

/// Calls f(nodes of the face, shape functions, position, displacement) at every quadrature point.
template <class F> void FollowerPressure::for_each_point(const Eigen::VectorXd& u, const F& f) const
{
    RETRACTOR_ASSERT(u.size() == 3 * rest_.rows());
    const auto rule = face_rule(nodes_per_face_ == 6);
    for (std::size_t begin = 0; begin < nodes_.size(); begin += nodes_per_face_) {
        const std::span<const VertexId> nodes(nodes_.data() + begin, nodes_per_face_);
        for (const FacePoint& reference : rule) {
            const FacePoint point = on_face(reference, nodes);
            SurfacePoint at, moved;
            for (std::size_t a = 0; a < nodes.size(); ++a) {
                const Vec3 by = u.segment<3>(3 * static_cast<Eigen::Index>(nodes[a]));
                const Vec3 to = rest_.row(nodes[a]).transpose() + by;
                at.x += point.N[a] * to;
                at.s += point.ds[a] * to;
                at.t += point.dt[a] * to;
                moved.x += point.N[a] * by;
                moved.s += point.ds[a] * by;
                moved.t += point.dt[a] * by;
            }
            f(nodes, point, at, moved);
        }
    }
}

/// Calls f(nodes of the side, shape functions, position at the last renewal, motion since then, derivative of the
/// motion along the side) at every quadrature point.
template <class F> void FollowerPressure::for_each_rim_point(const Eigen::VectorXd& u, const F& f) const
{
    RETRACTOR_ASSERT(u.size() == rim_at_.size());
    const auto rule = side_rule(nodes_per_face_ == 6);
    const std::size_t nodes_per_side = nodes_per_face_ == 6 ? 3 : 2;
    for (std::size_t begin = 0; begin < rim_.size(); begin += nodes_per_side) {
        const std::span<const VertexId> nodes(rim_.data() + begin, nodes_per_side);
        for (const SidePoint& reference : rule) {
            const SidePoint point = on_side(reference, nodes);
            Vec3 x = Vec3::Zero(), motion = Vec3::Zero(), along = Vec3::Zero();
            for (std::size_t a = 0; a < nodes.size(); ++a) {
                const auto i = 3 * static_cast<Eigen::Index>(nodes[a]);
                const Vec3 since = u.segment<3>(i) - rim_at_.segment<3>(i);
                x += point.N[a] * (rest_.row(nodes[a]).transpose() + rim_at_.segment<3>(i));
                motion += point.N[a] * since;
                along += point.dN[a] * since;
            }
            f(nodes, point, x, motion, along);
        }
    }
}

double FollowerPressure::add_response(const Eigen::VectorXd& u, double share, Eigen::VectorXd& gradient) const
{
    RETRACTOR_ASSERT(gradient.size() == u.size());
    double volume = 0.0; // increase of volume, by differences that are exact for tiny motions
    for_each_point(u, [&](auto nodes, const FacePoint& point, const SurfacePoint& at, const SurfacePoint& moved) {
        const auto& [x, s, t] = at;
        const Vec3 normal = s.cross(t);
        volume += point.weight / 3.0
            * (moved.x.dot(normal) + (x - moved.x).dot(moved.s.cross(t) + (s - moved.s).cross(moved.t)));
        for (std::size_t a = 0; a < nodes.size(); ++a)
            gradient.segment<3>(3 * static_cast<Eigen::Index>(nodes[a])) += share * pressure_ * point.weight / 3.0
                * (point.N[a] * normal + point.ds[a] * t.cross(x) + point.dt[a] * x.cross(s));
    });
    double by_rim = 0.0;
    for_each_rim_point(
        u, [&](auto nodes, const SidePoint& point, const Vec3& x, const Vec3& motion, const Vec3& along) {
            by_rim += point.weight / 6.0 * motion.dot(x.cross(along));
            for (std::size_t a = 0; a < nodes.size(); ++a)
                gradient.segment<3>(3 * static_cast<Eigen::Index>(nodes[a])) += share * pressure_ * point.weight / 6.0
                    * (point.N[a] * x.cross(along) - point.dN[a] * x.cross(motion));
        });
    return pressure_ * (volume + by_rim);
}

void FollowerPressure::add_stiffness(const Eigen::VectorXd& u, double share, BlockMatrix& K) const
{
    RETRACTOR_ASSERT(K.values.size() == 9 * K.pattern.block_count());
    for_each_point(u, [&](auto nodes, const FacePoint& p, const SurfacePoint& at, const SurfacePoint&) {
        const double w = share * pressure_ * p.weight / 3.0;
        const RowMat3 X = w * cross_matrix(at.x), S = w * cross_matrix(at.s), T = w * cross_matrix(at.t);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            for (std::size_t b = 0; b < nodes.size(); ++b)
                if (nodes[b] < nodes[a]) // the diagonal blocks are zero
                    lower_block(K, nodes[a], nodes[b]) += (p.dt[b] * p.N[a] - p.dt[a] * p.N[b]) * S
                        + (p.ds[a] * p.N[b] - p.N[a] * p.ds[b]) * T + (p.dt[a] * p.ds[b] - p.ds[a] * p.dt[b]) * X;
    });
    for_each_rim_point(u, [&](auto nodes, const SidePoint& p, const Vec3& x, const Vec3&, const Vec3&) {
        const RowMat3 X = share * pressure_ * p.weight / 6.0 * cross_matrix(x);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            for (std::size_t b = 0; b < nodes.size(); ++b)
                if (nodes[b] < nodes[a])
                    lower_block(K, nodes[a], nodes[b]) += (p.N[a] * p.dN[b] - p.dN[a] * p.N[b]) * X;
    });
}

Eigen::VectorXd FollowerPressure::force(const Eigen::VectorXd& u) const
{
    Eigen::VectorXd force = Eigen::VectorXd::Zero(u.size());
    for_each_point(u, [&](auto nodes, const FacePoint& point, const SurfacePoint& at, const SurfacePoint&) {
        const Vec3 f = -pressure_ * point.weight * at.s.cross(at.t);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            force.segment<3>(3 * static_cast<Eigen::Index>(nodes[a])) += point.N[a] * f;
    });
    return force;
}

} // namespace retractor::fem
