#include "fem/loads.h"

#include "fem/tet_element.h"
#include "mesh/base/error.h"
#include "mesh/triangle.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace retractor {

namespace {

    using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

    /// Shape functions of a triangle with three or six nodes and their derivatives by its first two coordinates.
    struct FacePoint {
        std::array<double, 6> N {}, ds {}, dt {};
        double weight = 0.0; ///< of the reference triangle, whose area is 1/2
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

    /// Corners counter-clockwise seen from outside, then the midpoints between them.
    std::vector<VertexId> face_nodes(const TetMesh& mesh, const TetFace& face)
    {
        const auto nodes = mesh.tet(face.tet);
        const auto& corner = kTetFaces[static_cast<std::size_t>(face.corner)];
        std::vector<VertexId> all;
        for (const int c : corner)
            all.push_back(nodes[static_cast<std::size_t>(c)]);
        for (std::size_t i = 0; mesh.nodes_per_tet == 10 && i < 3; ++i)
            for (std::size_t e = 0; e < kTetEdges.size(); ++e)
                if (std::minmax(corner[i], corner[(i + 1) % 3]) == std::minmax(kTetEdges[e][0], kTetEdges[e][1]))
                    all.push_back(nodes[4 + e]);
        return all;
    }

    void check_faces(const TetMesh& mesh, const std::vector<TetFace>& faces)
    {
        if (faces.empty())
            throw InputError("a load needs at least one face", "load");
        std::set<std::pair<TetId, int>> boundary;
        for (const TetFace& face : boundary_faces(mesh))
            boundary.insert({ face.tet, face.corner });
        for (const TetFace& face : faces)
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

    /// Keast's rule with 15 points [Keast 1986], exact for degree 5.
    std::vector<QuadraturePoint> fine_rule()
    {
        std::vector<QuadraturePoint> rule { { { 0.25, 0.25, 0.25, 0.25 }, 0.030283678097089 * 6.0 } };
        const auto corner = [&](double a, double w) {
            for (std::size_t i = 0; i < 4; ++i) {
                std::array<double, 4> b { a, a, a, a };
                b[i] = 1.0 - 3.0 * a;
                rule.push_back({ b, 6.0 * w });
            }
        };
        corner(1.0 / 3.0, 0.006026785714286);
        corner(1.0 / 11.0, 0.011645249086029);
        const double a = 0.066550153573664, b = 0.5 - a;
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = i + 1; j < 4; ++j) {
                std::array<double, 4> at { b, b, b, b };
                at[i] = at[j] = a;
                rule.push_back({ at, 6.0 * 0.010949141561386 });
            }
        return rule;
    }

} // namespace

void integrate(const TetMesh& mesh,
    const std::function<void(std::span<const VertexId>, const Eigen::VectorXd&, const Vec3&, double)>& f)
{
    const std::vector<QuadraturePoint> rule = fine_rule();
    NodeGradients rest(mesh.nodes_per_tet, 3);
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
        const auto nodes = mesh.tet(t);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            rest.row(static_cast<Eigen::Index>(a)) = mesh.vertices.row(nodes[a]);
        for (const QuadraturePoint& point : rule) {
            const Eigen::VectorXd values = shape_values(mesh.nodes_per_tet, point.barycentric);
            f(nodes, values, rest.transpose() * values, shape_gradients(rest, point).volume);
        }
    }
}

Eigen::VectorXd body_force_loads(const TetMesh& mesh, const std::function<Vec3(const Vec3&)>& force)
{
    Eigen::VectorXd loads = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
    integrate(mesh, [&](auto nodes, const Eigen::VectorXd& values, const Vec3& position, double weight) {
        const Vec3 f = weight * force(position);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            loads.segment<3>(3 * static_cast<Eigen::Index>(nodes[a])) += values[static_cast<Eigen::Index>(a)] * f;
    });
    return loads;
}

Eigen::VectorXd traction_loads(const TetMesh& mesh, const std::vector<TetFace>& faces, const Vec3& traction)
{
    check_faces(mesh, faces);
    std::vector<FaceTraction> tractions;
    tractions.reserve(faces.size());
    for (const TetFace& face : faces)
        tractions.push_back({ face, traction });
    return traction_loads(mesh, tractions);
}

Eigen::VectorXd traction_loads(const TetMesh& mesh, std::span<const FaceTraction> tractions)
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
        for (const FacePoint& point : rule) {
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

    /// Where to take V about, so that the rim adds little: what an edge of the rim adds is as large as the point is far
    /// from the plane through the edge square to the surface, which is the plane of symmetry where there is one. Least
    /// squares over the rim's length; the middle where that says little, as on flat or closed surfaces.
    Vec3 volume_origin(const Points& rest, const std::vector<VertexId>& nodes, std::size_t nodes_per_face)
    {
        const auto at = [&](VertexId v) -> Vec3 { return rest.row(v).transpose(); };
        Vec3 middle = Vec3::Zero();
        for (const VertexId v : nodes)
            middle += at(v) / static_cast<double>(nodes.size());
        struct Side {
            Vec3 point, out; ///< its middle, and the direction square to it in the face, times its length
            int faces = 0;
        };
        std::map<std::pair<VertexId, VertexId>, Side> sides;
        for (std::size_t begin = 0; begin < nodes.size(); begin += nodes_per_face) {
            const VertexId* corner = nodes.data() + begin;
            const Vec3 normal = unit_normal(at(corner[0]), at(corner[1]), at(corner[2]));
            for (std::size_t i = 0; i < 3; ++i) {
                const VertexId a = corner[i], b = corner[(i + 1) % 3];
                Side& side = sides[std::minmax(a, b)];
                side.point = 0.5 * (at(a) + at(b));
                side.out = (at(b) - at(a)).cross(normal);
                ++side.faces;
            }
        }
        Mat3 A = Mat3::Zero();
        Vec3 b = Vec3::Zero();
        for (const auto& [corners, side] : sides)
            if (const double length = side.out.norm(); side.faces == 1 && length > 0.0) {
                A += side.out * side.out.transpose() / length;
                b += side.out * side.out.dot(side.point - middle) / length;
            }
        if (!(A.trace() > 0.0))
            return middle;
        constexpr double kLittle = 1e-3; // keeps the point within some ten widths of a nearly flat surface
        A.diagonal().array() += kLittle * A.trace();
        return middle + A.inverse() * b;
    }

} // namespace

FollowerPressure::FollowerPressure(const TetMesh& mesh, const std::vector<TetFace>& faces, double pressure)
    : rest_(mesh.vertices)
    , nodes_per_face_(mesh.nodes_per_tet == 10 ? 6 : 3)
    , pressure_(pressure)
{
    check_faces(mesh, faces);
    if (!std::isfinite(pressure))
        throw InputError("the pressure is not finite", "load");
    for (const TetFace& face : faces) {
        const std::vector<VertexId> nodes = face_nodes(mesh, face);
        nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
    }
    origin_ = volume_origin(rest_, nodes_, nodes_per_face_);
}

/// Calls f(nodes of the face, shape functions, x, dx/ds, dx/dt) at every point, x from the origin.
template <class F> void FollowerPressure::for_each_point(const Eigen::VectorXd& u, const F& f) const
{
    const auto rule = face_rule(nodes_per_face_ == 6);
    for (std::size_t begin = 0; begin < nodes_.size(); begin += nodes_per_face_) {
        const std::span<const VertexId> nodes(nodes_.data() + begin, nodes_per_face_);
        for (const FacePoint& point : rule) {
            Vec3 x = -origin_, s = Vec3::Zero(), t = Vec3::Zero();
            for (std::size_t a = 0; a < nodes.size(); ++a) {
                const Vec3 at = rest_.row(nodes[a]).transpose() + u.segment<3>(3 * static_cast<Eigen::Index>(nodes[a]));
                x += point.N[a] * at;
                s += point.ds[a] * at;
                t += point.dt[a] * at;
            }
            f(nodes, point, x, s, t);
        }
    }
}

double FollowerPressure::add_response(const Eigen::VectorXd& u, double share, Eigen::VectorXd& gradient) const
{
    double volume = 0.0;
    for_each_point(u, [&](auto nodes, const FacePoint& point, const Vec3& x, const Vec3& s, const Vec3& t) {
        const Vec3 normal = s.cross(t);
        volume += point.weight / 3.0 * x.dot(normal);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            gradient.segment<3>(3 * static_cast<Eigen::Index>(nodes[a])) += share * pressure_ * point.weight / 3.0
                * (point.N[a] * normal + point.ds[a] * t.cross(x) + point.dt[a] * x.cross(s));
    });
    return pressure_ * volume;
}

void FollowerPressure::add_stiffness(const Eigen::VectorXd& u, double share, BlockMatrix& K) const
{
    const auto block = [&](VertexId row, VertexId column) {
        const auto begin = K.pattern.column.begin() + K.pattern.row_start[static_cast<std::size_t>(row)];
        const auto end = K.pattern.column.begin() + K.pattern.row_start[static_cast<std::size_t>(row) + 1];
        return K.values.data() + 9 * (std::lower_bound(begin, end, column) - K.pattern.column.begin());
    };
    for_each_point(u, [&](auto nodes, const FacePoint& p, const Vec3& x, const Vec3& s, const Vec3& t) {
        const double w = share * pressure_ * p.weight / 3.0;
        const RowMat3 X = w * cross_matrix(x), S = w * cross_matrix(s), T = w * cross_matrix(t);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            for (std::size_t b = 0; b < nodes.size(); ++b)
                if (nodes[b] < nodes[a]) // the diagonal blocks are zero
                    Eigen::Map<RowMat3>(block(nodes[a], nodes[b])) += (p.dt[b] * p.N[a] - p.dt[a] * p.N[b]) * S
                        + (p.ds[a] * p.N[b] - p.N[a] * p.ds[b]) * T + (p.dt[a] * p.ds[b] - p.ds[a] * p.dt[b]) * X;
    });
}

Eigen::VectorXd FollowerPressure::force(const Eigen::VectorXd& u) const
{
    Eigen::VectorXd force = Eigen::VectorXd::Zero(u.size());
    for_each_point(u, [&](auto nodes, const FacePoint& point, const Vec3&, const Vec3& s, const Vec3& t) {
        const Vec3 f = -pressure_ * point.weight * s.cross(t);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            force.segment<3>(3 * static_cast<Eigen::Index>(nodes[a])) += point.N[a] * f;
    });
    return force;
}

} // namespace retractor
