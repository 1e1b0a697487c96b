#pragma once
// Opens a wound: quasi-static elasticity of the cut wall with hooks as rigid patches. Units mm, N, MPa; frame patient
// LPS.
//
// - Linear: small-strain isotropic elasticity.
// - Corotational: the fixed-corotated energy mu |F - R|^2 + lambda/2 (det F - 1)^2 (Stomakhin and others 2012, eq.
// 4.2), whose linearisation is the linear model, with a penalty on tissue crushed below half its volume (elasticity.h).
// Newton-CG with line search and load steps (equilibrium.h) solves the problem, so that large hook displacements
// neither swell nor invert the tissue.
// - Hyperelastic: the laws of the materials, neo-Hookean by default (hyperelasticity.h). No step of the solver turns an
// element over.
//
// Four-node elements lock above a Poisson's ratio of about 0.49; use locking-free elements or ten-node elements
// (with_midpoints) there. OpeningOptions::near computes tissue near the wound nonlinearly and tissue beyond linearly,
// within an error limit (near_opening.h).

#include "fem/material/material.h"
#include "fem/statics/boundary_conditions.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/opening_types.h"
#include "mesh/base/job.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <memory>
#include <span>

namespace retractor::fem {

/// Holds the stiffness pattern of the mesh and its symbolic factorisation, both built when first needed. A further
/// open() starts from the last state with status converged, and keeps the ordering while the same nodes are held.
class Opening {
public:
    /// @param material_of_label indexed by label; entries of labels that no element has are not used
    /// @throws InputError on bad meshes, materials, supports, and on options that contradict each other
    Opening(const mesh::TetMesh& mesh, std::span<const Material> material_of_label, Supports supports,
        OpeningOptions options = {});
    /// Takes the loads of the problem too; the hooks of the problem are not used.
    /// @throws InputError as above, and when the options have a load as well
    Opening(const ElasticProblem& problem, OpeningOptions options = {});
    ~Opening();

    /// Opens the wound with these hooks.
    /// @throws InputError when a patch is empty, is out of range or holds a node that is not near, or when two patches
    /// prescribe different displacements of a node; SolverError naming size and place of a connected piece of the mesh
    /// without support and hook, and when a factorisation fails
    OpeningResult open(std::span<const HookPatch> hooks, const Job& job = {});

    /// Takes a displacement as the last state: the next open() starts from there. The opening by four-node elements is
    /// such a start for ten-node elements, and the opening without contact for one with contact: before the first
    /// open(), surfaces that pass through each other on the straight way to this start are paired (Contact::follow()).
    /// @param displacement n x 3, mm, all nodes
    /// @throws InputError on a wrong number of rows, or a displacement that is not finite
    void start_from(const Points& displacement);

    /// Changes OpeningOptions::load_steps for the openings that follow: a start near the answer needs fewer steps.
    /// @throws InputError on less than one step
    void set_load_steps(int least);

    /// Changes OpeningOptions::tolerance and energy_tolerance for the openings that follow: on the way to an answer
    /// rough ones are enough.
    /// @throws InputError on a tolerance that is not between 0 and 1; the second may be 0
    void set_tolerance(double tolerance, double energy_tolerance);

    /// Multiplies the stiffness of some elements for the openings that follow.
    /// @pre open() was called, without OpeningOptions::near; the elements have corotational or linear elasticity and
    /// are not locking-free
    void stiffen(std::span<const TetId> elements, double factor);

    /// Stiffness against small motions of the hooks' nodes, linearised at the state of the last open(); cheaper than
    /// motion_response(), because the ordering is there.
    /// @param displacement n x 3, mm, all nodes: of the last open()
    /// @param motions one motion per column, three entries per node; zero at nodes that are free
    /// @return force of each motion (virtual work) per unit of each motion, N/mm for motions in mm, symmetric
    /// @pre open() was called, without OpeningOptions::near
    /// @throws SolverError when the stiffness cannot be factored
    Eigen::MatrixXd stiffness(const Points& displacement, const Eigen::MatrixXd& motions);

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::fem
