#pragma once
// An opened wound as a problem of elasticity. The same problem is solved here, written for other programs, and used to
// estimate the discretisation error. Units mm, N, MPa; frame patient LPS.

#include "fem/material/elasticity.h"
#include "fem/material/material.h"
#include "fem/model/blade_samples.h"
#include "fem/model/elastic_body.h"
#include "fem/model/loads.h"
#include "fem/statics/boundary_conditions.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::fem {

struct ElasticProblem {
    mesh::TetMesh mesh; ///< with the cut, at rest; P1 or P2
    std::vector<Material> material_of_label; ///< indexed by label; entries of labels that no element has are not used
    Supports supports;
    std::vector<HookPatch> hooks;
    std::vector<FaceTraction> loads {}; ///< on faces of the mesh: the tension that the cut released (pre_strain.h)
    /// Pressure of the surroundings on surfaces; a linear body receives the pressure at rest.
    std::vector<SurfacePressure> pressures {};
    /// Hooks in unilateral contact: rigid blades. The nodes of such a hook are the nodes of its blade, which no element
    /// has and which follow the corners of the elements in the mesh (add_blade()).
    std::vector<BladeSurface> blades {};
};

/// Turns a hook into a blade in contact: adds the three nodes of the blade to the mesh, gives them to the hook in place
/// of its own, and finds the places that the blade can touch (blade_samples.h).
/// @param hook index into problem.hooks
/// @pre four-node elements
/// @throws InputError as make_blade_surface()
void add_blade(ElasticProblem& problem, std::size_t hook, std::span<const mesh::TetFace> lip,
    std::span<const mesh::TetFace> bone, const BladePlace& place);

/// A displacement of the vertices of the elements, n x 3, mm, followed by that of the nodes of the blades where their
/// hooks are. Other nodes, such as midpoints, are not added.
Points with_blade_nodes(const ElasticProblem& problem, const Points& displacement);

/// The unknowns that supports and hooks prescribe: a flag and a value per unknown.
struct Prescribed {
    std::vector<std::uint8_t> flag; ///< three per node, 1 = prescribed
    Eigen::VectorXd value;
    std::vector<VertexId> nodes;
    std::vector<int> hook_of_node; ///< hook that receives the force of each node; -1: none
};

/// Collects the prescribed unknowns.
/// @throws InputError when a node is out of range, a patch is empty, or two patches prescribe different displacements
/// of a node
Prescribed prescribe(const mesh::TetMesh& mesh, const Supports& supports, std::span<const HookPatch> hooks);

/// Lame parameters, one per element.
/// @throws InputError naming the element whose label has no material, or the invalid material
std::vector<Lame> element_parameters(const mesh::TetMesh& mesh, std::span<const Material> material_of_label);

/// The law of each element: hyperelastic_law() of its label, with the fibres of that material.
/// @throws InputError as element_parameters() and element_fibres()
HyperelasticTissue hyperelastic_tissue(const mesh::TetMesh& mesh, std::span<const Material> material_of_label);

/// The choice of equations.
struct TissueModel {
    Elasticity elasticity = Elasticity::corotational;
    bool locking_free = false; ///< only for four-node elements: uses the elements of locking_free.h
};

/// Makes a body of the mesh with these materials.
/// @throws InputError as element_parameters() and ElasticBody::avoid_locking()
ElasticBody tissue_body(
    const mesh::TetMesh& mesh, std::span<const Material> material_of_label, const TissueModel& model);

/// Stiffness of the bed, N/mm, one per node; empty without a bed.
/// @throws InputError on a vertex out of range or named twice, or a stiffness that is not positive
std::vector<double> bed_stiffness(const mesh::TetMesh& mesh, const Supports& supports);

/// Gives a body the beds and hinges of its supports.
/// @throws InputError as bed_stiffness() and check_hinges()
void set_springs(ElasticBody& body, const Supports& supports);

/// Checks mesh, materials, supports, hooks and loads.
/// @throws InputError as the functions above and check_mesh(), and on a mesh without elements
void check_problem(const ElasticProblem& problem);

/// The loads of the problem in the form that a body takes.
/// @throws InputError as traction_loads() and FollowerPressure
ExternalLoads external_loads(const ElasticProblem& problem);

/// The loads of the problem at rest, pressures included, N, three per node; empty without loads.
/// @throws InputError as external_loads()
Eigen::VectorXd nodal_loads(const ElasticProblem& problem);

/// The labels of the elements of the mesh, rising.
std::vector<Label> labels_met(const mesh::TetMesh& mesh);

/// Sums nodal forces (three per node) over the nodes of each hook.
std::vector<Vec3> hook_forces(const Eigen::VectorXd& nodal_forces, const Prescribed& prescribed, std::size_t hooks);

/// The motions of the hooks: three columns per hook, a displacement of 1 mm of its nodes along x, y and z; three rows
/// per node.
Eigen::MatrixXd hook_motions(const Prescribed& prescribed, std::size_t hooks);

} // namespace retractor::fem
