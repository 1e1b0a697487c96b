#pragma once
// Shape functions and quadrature of the four-node (P1) and ten-node (P2) tetrahedron. Node order: tet_mesh.h.

#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <array>
#include <span>

namespace retractor::fem {

/// Barycentric coordinates and weight of a point. The weights of a rule sum to 1.
struct QuadraturePoint {
    std::array<double, 4> barycentric;
    double weight = 0.0;
};

/// The quadrature rule of an element. P1 has the centroid, which is exact for its constant gradients. P2 has four
/// points, exact for degree 2, which a straight-edged element needs (CalculiX's C3D10 uses the same points).
std::span<const QuadraturePoint> quadrature(int nodes_per_tet);

/// n x 3, one row per node.
using NodeGradients = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor, 10, 3>;

/// Values of the shape functions at a point, one row per node.
Eigen::VectorXd shape_values(int nodes_per_tet, const std::array<double, 4>& barycentric);

/// Gradients of the shape functions in rest coordinates, and the rest volume that belongs to the quadrature point.
struct ShapeGradients {
    NodeGradients gradients; ///< n x 3, 1/mm
    double volume = 0.0; ///< weight times Jacobian, mm^3
};
/// @param nodes n x 3, rest positions of the element's nodes, mm. The volume is not positive where the element is
/// inverted.
ShapeGradients shape_gradients(const NodeGradients& nodes, const QuadraturePoint& point);

/// Rest positions of an element's nodes, n x 3, mm. A straight edge (tet_mesh.h) has its middle in place of its
/// midpoint.
NodeGradients rest_positions(const mesh::TetMesh& mesh, TetId t);
/// As above, for an element of a mesh. A straight edge adds half of its function to each of its ends; its own row is
/// zero.
Eigen::VectorXd shape_values(const mesh::TetMesh& mesh, TetId t, const std::array<double, 4>& barycentric);
ShapeGradients shape_gradients(const mesh::TetMesh& mesh, TetId t, const QuadraturePoint& point);

} // namespace retractor::fem
