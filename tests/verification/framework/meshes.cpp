#include "tests/verification/framework/meshes.h"

#include "fem/model/loads.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"
#include "tests/verification/framework/body_force.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include <numbers>
#include <random>
#include <set>

namespace retractor::verification {

Held hold_nothing(const mesh::TetMesh& mesh)
{
    return { std::vector<std::uint8_t>(3 * mesh.vertex_count(), 0), Eigen::VectorXd::Zero(3 * mesh.vertices.rows()) };
}

void hold(Held& held, VertexId vertex, int axis, double value)
{
    held.prescribed[3 * static_cast<std::size_t>(vertex) + static_cast<std::size_t>(axis)] = 1;
    held.target[3 * vertex + axis] = value;
}

mesh::TetMesh mapped_box(int nodes_per_tet, int nx, int ny, int nz, const std::function<Vec3(const Vec3&)>& map)
{
    mesh::TetMesh mesh = mesh::kuhn_box(nx, ny, nz, 1.0);
    if (nodes_per_tet == 10)
        mesh = mesh::with_midpoints(mesh);
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        mesh.vertices.row(v) = map(mesh.vertices.row(v).transpose()).transpose();
    mesh::check_mesh(mesh);
    return mesh;
}

std::vector<mesh::TetFace> faces_where(const mesh::TetMesh& mesh, const std::function<bool(const Vec3&)>& inside)
{
    std::vector<mesh::TetFace> faces;
    for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
        const auto corners = mesh::face_vertices(mesh, face);
        if (std::all_of(
                corners.begin(), corners.end(), [&](VertexId v) { return inside(mesh.vertices.row(v).transpose()); }))
            faces.push_back(face);
    }
    return faces;
}

QuarterTube quarter_tube(int nodes_per_tet, double inner, double outer, int around, int through, int along)
{
    // Elements are about as long as thick. "Around" runs clockwise, so that (around, out, along) is right-handed.
    const double length = (outer - inner) / through * along;
    QuarterTube tube;
    tube.mesh = mapped_box(nodes_per_tet, around, through, along, [&](const Vec3& p) -> Vec3 {
        const double angle = std::numbers::pi / 2 * p.x() / around, r = inner + (outer - inner) * p.y() / through;
        return { r * std::sin(angle), r * std::cos(angle), length * p.z() / along };
    });
    tube.held = hold_nothing(tube.mesh);
    const double tiny = 1e-9 * outer;
    const auto on_inner
        = [&](const Vec3& p) { return std::hypot(p.x(), p.y()) < inner + 0.1 * (outer - inner) / through; };
    for (VertexId v = 0; v < static_cast<VertexId>(tube.mesh.vertex_count()); ++v) {
        const Vec3 p = tube.mesh.vertices.row(v).transpose();
        if (p.x() < tiny)
            hold(tube.held, v, 0);
        if (p.y() < tiny)
            hold(tube.held, v, 1);
        if (p.z() < tiny || p.z() > length - tiny)
            hold(tube.held, v, 2);
        if (on_inner(p))
            tube.inner.push_back(v);
    }
    tube.inner_faces = faces_where(tube.mesh, on_inner);
    return tube;
}

double inner_displacement(const QuarterTube& tube, const Eigen::VectorXd& u)
{
    double sum = 0.0;
    for (const VertexId v : tube.inner) {
        const Eigen::Vector2d p = tube.mesh.vertices.row(v).head<2>().transpose();
        sum += p.normalized().dot(u.segment<2>(3 * v));
    }
    return sum / static_cast<double>(tube.inner.size());
}

mesh::TetMesh distorted_box(int n, double spacing, double share, unsigned seed)
{
    mesh::TetMesh mesh = mesh::kuhn_box(n, n, n, spacing);
    std::mt19937 random(seed);
    const auto move = [&] { return share * spacing * (2.0 * static_cast<double>(random()) / 4294967295.0 - 1.0); };
    const double size = n * spacing;
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
        const Vec3 p = mesh.vertices.row(v).transpose();
        if (p.minCoeff() > 0.0 && p.maxCoeff() < size)
            for (int axis = 0; axis < 3; ++axis)
                mesh.vertices(v, axis) += move();
    }
    mesh::check_mesh(mesh);
    return mesh;
}

mesh::TetMesh box_with_sliver(double height)
{
    mesh::TetMesh mesh = distorted_box(3, 1.0, 0.15, 4);
    const auto nodes = mesh.tet(80);
    // The element's volume is linear in each vertex, so moving one vertex towards the plane of the others scales the
    // volume.
    for (std::size_t a = 0; a < 4; ++a) {
        mesh::TetMesh moved = mesh;
        const auto& face = mesh::kTetFaces[a];
        const Vec3 p0 = mesh.vertices.row(nodes[static_cast<std::size_t>(face[0])]),
                   p1 = mesh.vertices.row(nodes[static_cast<std::size_t>(face[1])]),
                   p2 = mesh.vertices.row(nodes[static_cast<std::size_t>(face[2])]), p = mesh.vertices.row(nodes[a]);
        if (p.minCoeff() < 0.5 || p.maxCoeff() > 2.5)
            continue; // keep the boundary of the box
        const Vec3 normal = unit_normal(p0, p1, p2);
        const double distance = normal.dot(p - p0);
        moved.vertices.row(nodes[a]) -= ((1.0 - height) * distance * normal).transpose();
        try {
            mesh::check_mesh(moved);
            return moved;
        } catch (const InputError&) { // a neighbour was inverted: try the next corner
        }
    }
    throw InputError("no sliver could be made");
}

mesh::TetMesh mirrored(const mesh::TetMesh& half, int axis, const std::function<bool(const Vec3&)>& shared)
{
    const double tiny = 1e-9 * half.vertices.cwiseAbs().maxCoeff();
    mesh::TetMesh whole = half;
    std::vector<VertexId> image(half.vertex_count());
    VertexId next = static_cast<VertexId>(half.vertex_count());
    for (std::size_t v = 0; v < image.size(); ++v) {
        const Vec3 p = half.vertices.row(static_cast<Eigen::Index>(v)).transpose();
        image[v] = std::abs(p[axis]) < tiny && shared(p) ? static_cast<VertexId>(v) : next++;
    }
    whole.vertices.conservativeResize(next, 3);
    for (std::size_t v = 0; v < image.size(); ++v)
        if (image[v] != static_cast<VertexId>(v)) {
            whole.vertices.row(image[v]) = half.vertices.row(static_cast<Eigen::Index>(v));
            whole.vertices(image[v], axis) *= -1.0;
        }
    for (TetId t = 0; t < static_cast<TetId>(half.tet_count()); ++t) {
        const auto nodes = half.tet(t);
        for (const std::size_t a : { 1U, 0U, 2U, 3U }) // reordered, because mirroring inverts the element
            whole.nodes.push_back(image[static_cast<std::size_t>(nodes[a])]);
    }
    whole.labels.insert(whole.labels.end(), half.labels.begin(), half.labels.end());
    mesh::check_mesh(whole);
    return whole;
}

mesh::TetMesh side_by_side(const mesh::TetMesh& mesh, int copies)
{
    mesh::TetMesh all;
    all.nodes_per_tet = mesh.nodes_per_tet;
    const Eigen::Index n = mesh.vertices.rows();
    all.vertices.resize(n * copies, 3);
    for (int c = 0; c < copies; ++c) {
        all.vertices.middleRows(c * n, n) = mesh.vertices.rowwise() + Eigen::RowVector3d(10.0 * c, 0, 0);
        for (const VertexId v : mesh.nodes)
            all.nodes.push_back(v + static_cast<VertexId>(c * n));
        all.labels.insert(all.labels.end(), mesh.labels.begin(), mesh.labels.end());
    }
    return all;
}

Held hold_boundary(const mesh::TetMesh& mesh, const std::function<Vec3(const Vec3&)>& field)
{
    Held held = hold_nothing(mesh);
    const auto set = [&](VertexId v) {
        const Vec3 value = field(mesh.vertices.row(v).transpose());
        for (int axis = 0; axis < 3; ++axis)
            hold(held, v, axis, value[axis]);
    };
    for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
        for (const VertexId v : mesh::face_vertices(mesh, face))
            set(v);
        for (std::size_t e = 0; mesh.nodes_per_tet == 10 && e < mesh::kTetEdges.size(); ++e)
            if (mesh::kTetEdges[e][0] != face.corner && mesh::kTetEdges[e][1] != face.corner)
                set(mesh.tet(face.tet)[4 + e]);
    }
    return held;
}

Eigen::VectorXd nodal_values(const mesh::TetMesh& mesh, const std::function<Vec3(const Vec3&)>& field)
{
    Eigen::VectorXd u(3 * mesh.vertices.rows());
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
        u.segment<3>(3 * v) = field(mesh.vertices.row(v).transpose());
    return u;
}

double l2_error(const mesh::TetMesh& mesh, const Eigen::VectorXd& u_h, const std::function<Vec3(const Vec3&)>& u)
{
    double sum = 0.0;
    integrate(mesh, [&](auto nodes, const Eigen::VectorXd& values, const Vec3& position, double weight) {
        Vec3 difference = -u(position);
        for (std::size_t a = 0; a < nodes.size(); ++a)
            difference += values[static_cast<Eigen::Index>(a)]
                * u_h.template segment<3>(3 * static_cast<Eigen::Index>(nodes[a]));
        sum += weight * difference.squaredNorm();
    });
    return std::sqrt(sum);
}

} // namespace retractor::verification
