#pragma once
// Pulling a wound open: quasi-static elasticity on the cut wall with hooks as rigid patches.
// Units mm, N, MPa; frame patient LPS.
//
// Linear: small-strain isotropic elasticity. Corotational: the fixed-corotated energy
// mu |F - R|^2 + lambda/2 (det F - 1)^2 [Stomakhin et al. 2012, eq. 4.2], whose linearisation is the linear model, with
// a penalty on tissue crushed below half its volume (elasticity.h); Newton-CG with line search and load steps
// (equilibrium.h), so that large hook displacements neither swell nor invert the tissue. Hyperelastic: the materials'
// own laws, neo-Hookean where they have none (hyperelasticity.h); no step of the solver turns an element over.
//
// Four-node elements lock above nu of about 0.49: there take locking-free ones or ten-node ones (with_midpoints).
// Nonlinear near the wound and linear beyond, as far as that is right: OpeningOptions::near (near_opening.h).

#include "fem/material/material.h"
#include "fem/statics/boundary_conditions.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/opening_types.h"
#include "mesh/base/job.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <memory>
#include <span>

namespace retractor::fem {

/// Holds the mesh's stiffness pattern and its symbolic factorisation; both are built when first needed. A further
/// open() starts from the last converged state (status converged), and with the same nodes held it keeps the ordering.
class Opening {
public:
    /// @param materials one per element label id: materials_of_label[label]; labels not met may be anything.
    /// @throws InputError on bad meshes, materials, supports, and on options that contradict each other.
    Opening(const mesh::TetMesh& mesh, std::span<const Material> material_of_label, Supports supports,
        OpeningOptions options = {});
    /// With the problem's loads; its hooks are not used. @throws InputError as above, and where the options have a load
    /// too.
    Opening(const ElasticProblem& problem, OpeningOptions options = {});
    ~Opening();
    Opening(Opening&&) noexcept;

    /// @throws InputError when a patch is empty, out of range, holds a node that is not near, or two patches disagree
    /// on a node; SolverError naming the piece when a connected piece of the mesh has neither support nor hook (its
    /// size and place are in the message), and when a factorisation fails.
    OpeningResult open(std::span<const HookPatch> hooks, const Job& job = {});

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::fem
