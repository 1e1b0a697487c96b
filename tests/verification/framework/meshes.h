#pragma once
// Meshes of the reference problems with their prescribed unknowns. Units mm.

#include "mesh/tetrahedra/tet_mesh.h"
#include "tests/verification/framework/problem.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace retractor::verification {

/// Prescribed unknowns, three per node: a flag (1 = prescribed) and the prescribed displacement, mm.
struct Held {
    std::vector<std::uint8_t> prescribed;
    Eigen::VectorXd target;
};
Held hold_nothing(const mesh::TetMesh& mesh);
void hold(Held& held, VertexId vertex, int axis, double value = 0.0);

/// A box of Kuhn cells from the origin, mapped. Midpoints of ten-node elements are mapped too and lie on the curve.
mesh::TetMesh mapped_box(int nodes_per_tet, int nx, int ny, int nz, const std::function<Vec3(const Vec3&)>& map);

/// Boundary faces whose corners all satisfy the predicate.
std::vector<mesh::TetFace> faces_where(const mesh::TetMesh& mesh, const std::function<bool(const Vec3&)>& inside);

/// A quarter of a thick-walled tube round z in plane strain, with symmetry planes x = 0 and y = 0.
struct QuarterTube {
    mesh::TetMesh mesh;
    Held held;
    std::vector<VertexId> inner; ///< nodes on the inner wall
    std::vector<mesh::TetFace> inner_faces;
};
QuarterTube quarter_tube(int nodes_per_tet, double inner, double outer, int around, int through, int along);
/// Mean radial displacement of the inner wall, mm.
double inner_displacement(const QuarterTube& tube, const Eigen::VectorXd& u);

/// A Kuhn box whose inner vertices are moved at random by up to `share` of the spacing, equally on every machine.
mesh::TetMesh distorted_box(int n, double spacing, double share, unsigned seed);
/// A distorted box in which one inner vertex lies nearly on the opposite face of one of its elements. This element
/// has `height` times its former volume.
mesh::TetMesh box_with_sliver(double height);
/// A body and its mirror image beyond the plane where the coordinate `axis` is zero. Vertices in the plane are shared
/// where `shared` is true for their position. Four-node elements.
mesh::TetMesh mirrored(const mesh::TetMesh& half, int axis, const std::function<bool(const Vec3&)>& shared);
/// Copies of a mesh, 10 mm apart along x.
mesh::TetMesh side_by_side(const mesh::TetMesh& mesh, int copies);

/// Prescribes the displacement `field` at all nodes of the boundary.
Held hold_boundary(const mesh::TetMesh& mesh, const std::function<Vec3(const Vec3&)>& field);
/// Values of a field at the nodes, three per node.
Eigen::VectorXd nodal_values(const mesh::TetMesh& mesh, const std::function<Vec3(const Vec3&)>& field);
/// L2 norm of the error: the square root of the integral of |u_h - u|^2.
double l2_error(const mesh::TetMesh& mesh, const Eigen::VectorXd& u_h, const std::function<Vec3(const Vec3&)>& u);

} // namespace retractor::verification
