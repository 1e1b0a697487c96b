#include "fem/element/tet_element.h"

#include "mesh/base/assert.h"

#include <Eigen/LU>

namespace retractor::fem {

namespace {

    constexpr std::array<QuadraturePoint, 1> kCentroid { { { { 0.25, 0.25, 0.25, 0.25 }, 1.0 } } };
    constexpr double kNear = 0.58541019662496845446,
                     kFar = 0.13819660112501051518; // (5 + 3 sqrt 5)/20, (5 - sqrt 5)/20
    constexpr std::array<QuadraturePoint, 4> kFourPoints { { { { kNear, kFar, kFar, kFar }, 0.25 },
        { { kFar, kNear, kFar, kFar }, 0.25 }, { { kFar, kFar, kNear, kFar }, 0.25 },
        { { kFar, kFar, kFar, kNear }, 0.25 } } };

    /// Derivatives of the four barycentric coordinates by the reference coordinates. The reference coordinates are
    /// the last three barycentric coordinates.
    Eigen::Matrix<double, 4, 3> barycentric_derivatives()
    {
        Eigen::Matrix<double, 4, 3> d;
        d << -1, -1, -1, 1, 0, 0, 0, 1, 0, 0, 0, 1;
        return d;
    }

    NodeGradients reference_gradients(Eigen::Index nodes, const std::array<double, 4>& b)
    {
        const Eigen::Matrix<double, 4, 3> d = barycentric_derivatives();
        NodeGradients g(nodes, 3);
        if (nodes == 4) {
            g = d;
            return g;
        }
        for (std::size_t a = 0; a < 4; ++a)
            g.row(static_cast<Eigen::Index>(a)) = (4.0 * b[a] - 1.0) * d.row(static_cast<Eigen::Index>(a));
        for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e) {
            const int i = mesh::kTetEdges[e][0], j = mesh::kTetEdges[e][1];
            g.row(static_cast<Eigen::Index>(4 + e))
                = 4.0 * (b[static_cast<std::size_t>(j)] * d.row(i) + b[static_cast<std::size_t>(i)] * d.row(j));
        }
        return g;
    }

} // namespace

std::span<const QuadraturePoint> quadrature(int nodes_per_tet)
{
    RETRACTOR_ASSERT(nodes_per_tet == 4 || nodes_per_tet == 10);
    if (nodes_per_tet == 4)
        return kCentroid;
    return kFourPoints;
}

Eigen::VectorXd shape_values(int nodes_per_tet, const std::array<double, 4>& b)
{
    RETRACTOR_ASSERT(nodes_per_tet == 4 || nodes_per_tet == 10);
    if (nodes_per_tet == 4)
        return Eigen::Map<const Eigen::Vector4d>(b.data());
    Eigen::VectorXd values(10);
    for (std::size_t a = 0; a < 4; ++a)
        values[static_cast<Eigen::Index>(a)] = b[a] * (2.0 * b[a] - 1.0);
    for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e)
        values[static_cast<Eigen::Index>(4 + e)] = 4.0 * b[static_cast<std::size_t>(mesh::kTetEdges[e][0])]
            * b[static_cast<std::size_t>(mesh::kTetEdges[e][1])];
    return values;
}

ShapeGradients shape_gradients(const NodeGradients& nodes, const QuadraturePoint& point)
{
    RETRACTOR_ASSERT(nodes.rows() == 4 || nodes.rows() == 10);
    const NodeGradients reference = reference_gradients(nodes.rows(), point.barycentric);
    const Mat3 jacobian = nodes.transpose() * reference; // d position / d reference coordinate
    ShapeGradients shape;
    shape.gradients = reference * jacobian.inverse();
    shape.volume = point.weight * jacobian.determinant() / 6.0;
    return shape;
}

namespace {

    template <class Rows> void add_straight_edges_to_ends(std::span<const VertexId> nodes, Rows& rows)
    {
        for (std::size_t e = 0; nodes.size() == 10 && e < mesh::kTetEdges.size(); ++e)
            if (mesh::is_straight(nodes, e)) {
                auto own = rows.row(static_cast<Eigen::Index>(4 + e));
                for (const int end : mesh::kTetEdges[e])
                    rows.row(end) += 0.5 * own;
                own.setZero();
            }
    }

} // namespace

NodeGradients rest_positions(const mesh::TetMesh& mesh, TetId t)
{
    const auto nodes = mesh.tet(t);
    NodeGradients positions(static_cast<Eigen::Index>(nodes.size()), 3);
    for (std::size_t a = 0; a < nodes.size(); ++a)
        positions.row(static_cast<Eigen::Index>(a)) = mesh.vertices.row(nodes[a]);
    for (std::size_t e = 0; nodes.size() == 10 && e < mesh::kTetEdges.size(); ++e)
        if (mesh::is_straight(nodes, e))
            positions.row(static_cast<Eigen::Index>(4 + e))
                = 0.5 * (positions.row(mesh::kTetEdges[e][0]) + positions.row(mesh::kTetEdges[e][1]));
    return positions;
}

Eigen::VectorXd shape_values(const mesh::TetMesh& mesh, TetId t, const std::array<double, 4>& barycentric)
{
    Eigen::VectorXd values = shape_values(mesh.nodes_per_tet, barycentric);
    add_straight_edges_to_ends(mesh.tet(t), values);
    return values;
}

ShapeGradients shape_gradients(const mesh::TetMesh& mesh, TetId t, const QuadraturePoint& point)
{
    ShapeGradients shape = shape_gradients(rest_positions(mesh, t), point);
    add_straight_edges_to_ends(mesh.tet(t), shape.gradients);
    return shape;
}

} // namespace retractor::fem
