#pragma once
// Shape functions and quadrature of the four-node (P1) and ten-node (P2) tetrahedron. Node order: tet_mesh.h.

#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <array>
#include <span>
#include <vector>

namespace retractor::fem {

/// Barycentric coordinates and a weight; the weights of a rule sum to 1.
struct QuadraturePoint {
    std::array<double, 4> barycentric;
    double weight = 0.0;
};

/// P1: the centroid, exact for its constant gradients. P2: four points, exact for degree 2, which a straight-edged
/// element needs (and what CalculiX's C3D10 uses).
std::span<const QuadraturePoint> quadrature(int nodes_per_tet);

/// One row per node.
using NodeGradients = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor, 10, 3>;

/// Values of the shape functions; n rows.
Eigen::VectorXd shape_values(int nodes_per_tet, const std::array<double, 4>& barycentric);

/// Gradients of the shape functions in rest coordinates, and the rest volume the point stands for.
struct ShapeGradients {
    NodeGradients gradients; ///< n x 3, 1/mm
    double volume = 0.0; ///< mm^3, weight times Jacobian
};
/// @param nodes n x 3 rest positions of the element's nodes. The volume is not positive when the element is turned over
/// there.
ShapeGradients shape_gradients(const NodeGradients& nodes, const QuadraturePoint& point);

} // namespace retractor::fem
