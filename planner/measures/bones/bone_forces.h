#pragma once
// The forces on one bone of the solved wall, as a free body. The bone's own elements give the nodal forces with which
// the bone resists its deformation. In equilibrium these are the forces with which soft tissue, cartilage, joints and
// hooks act on the bone's nodes. Units mm, N, MPa; frame patient LPS.

#include "fem/material/material.h"
#include "fem/statics/elastic_problem.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <span>
#include <vector>

namespace retractor::planner {

/// A connected piece of a bone.
struct BoneForces {
    mesh::TetMesh part; ///< the elements of the piece with their own nodes, at rest
    std::vector<VertexId> node_of; ///< node of the wall for each node of the part
    /// Positions about which the forces balance, n x 3, mm: deformed, or at rest where the elasticity is linear.
    Points positions;
    Points forces; ///< on each node from outside the bone, n x 3, N; they add up to zero in force and in moment
};

/// The forces on each connected piece of a bone, the piece with most elements first.
/// @param wall the solved wall, four-node or ten-node elements
/// @param displacement three per node of the wall, mm
/// @throws InputError when the displacement has another size, or as fem::tissue_body(); SolverError when a force is not
/// finite, because an element of the bone is turned over
std::vector<BoneForces> bone_forces(const mesh::TetMesh& wall, std::span<const fem::Material> material_of_label,
    const fem::TissueModel& model, const Eigen::VectorXd& displacement, Label bone);

} // namespace retractor::planner
