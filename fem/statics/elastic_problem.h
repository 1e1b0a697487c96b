#pragma once
// An opened wound as a problem of elasticity: what is solved here, written for other programs and estimated for its
// error. Units mm, N, MPa; frame patient LPS.

#include "fem/material/elasticity.h"
#include "fem/material/material.h"
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
    mesh::TetMesh mesh; ///< cut, at rest; P1 or P2
    std::vector<Material> material_of_label; ///< by label; labels not met may be anything
    Supports supports;
    std::vector<HookPatch> hooks;
    std::vector<FaceTraction> loads {}; ///< on faces of the mesh: the tension that the cut set free (pre_strain.h)
    std::vector<SurfacePressure> pressures {}; ///< of what the tissue borders on; linear bodies feel them as at rest
};

/// What supports and hooks prescribe: a flag and a value per unknown.
struct Prescribed {
    std::vector<std::uint8_t> flag; ///< three per node, 1 = prescribed
    Eigen::VectorXd value;
    std::vector<VertexId> nodes;
    std::vector<int> hook_of_node; ///< the hook a node's force is counted for; -1: none
};

/// @throws InputError when a node is out of range, a patch is empty, or two patches disagree on a node.
Prescribed prescribe(const mesh::TetMesh& mesh, const Supports& supports, std::span<const HookPatch> hooks);

/// One per element. @throws InputError naming the element whose label has no material, or the material that is wrong.
std::vector<Lame> element_parameters(const mesh::TetMesh& mesh, std::span<const Material> material_of_label);

/// Each element by its label's hyperelastic_law(), with that material's fibres in it. @throws InputError as above, and
/// as element_fibres() does.
HyperelasticTissue hyperelastic_tissue(const mesh::TetMesh& mesh, std::span<const Material> material_of_label);

/// What the equations are made of.
struct TissueModel {
    Elasticity elasticity = Elasticity::corotational;
    bool locking_free = false; ///< four-node elements only: locking_free.h in place of plain ones
};

/// The mesh as a body of these materials. @throws InputError as above, and as ElasticBody::avoid_locking() does.
ElasticBody tissue_body(
    const mesh::TetMesh& mesh, std::span<const Material> material_of_label, const TissueModel& model);

/// N/mm, one per node; empty when nothing is bedded. @throws InputError on a vertex out of range or named twice, or a
/// stiffness that is not positive.
std::vector<double> bed_stiffness(const mesh::TetMesh& mesh, const Supports& supports);

/// All of the above, its loads and check_mesh(). @throws InputError as they do, and on a mesh without elements.
void check_problem(const ElasticProblem& problem);

/// The problem's loads as a body of its mesh takes them. @throws InputError as traction_loads() and FollowerPressure.
ExternalLoads external_loads(const ElasticProblem& problem);

/// The same at rest, pressures too, N, three per node; empty where there are none. @throws InputError as above.
Eigen::VectorXd nodal_loads(const ElasticProblem& problem);

/// The labels that elements of the mesh carry, rising.
std::vector<Label> labels_met(const mesh::TetMesh& mesh);

/// Forces at the nodes (three per node), summed over the nodes of each hook.
std::vector<Vec3> hook_forces(const Eigen::VectorXd& nodal_forces, const Prescribed& prescribed, std::size_t hooks);

} // namespace retractor::fem
