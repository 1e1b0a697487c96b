#pragma once
// Integrals over a mesh, and the nodal loads of a force per volume. Units mm, N.

#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <functional>
#include <span>

namespace retractor::verification {

/// Calls f(nodes, shape values, rest position, weight in mm^3) at points of each element; exact for degree 5.
void integrate(const mesh::TetMesh& mesh,
    const std::function<void(std::span<const VertexId>, const Eigen::VectorXd&, const Vec3&, double)>& f);

/// Consistent nodal loads of a force per volume, N/mm^3, at rest positions; integrated exactly for degree 5 in all.
Eigen::VectorXd body_force_loads(const mesh::TetMesh& mesh, const std::function<Vec3(const Vec3&)>& force);

} // namespace retractor::verification
