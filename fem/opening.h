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

#include "fem/contact.h"
#include "fem/elasticity.h"
#include "fem/loads.h"
#include "fem/material.h"
#include "mesh/base/job.h"
#include "mesh/tet_mesh.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor {

/// A vertex that rests on tissue which is not modelled: a spring to where it was, the same in every direction.
struct BeddedVertex {
    VertexId vertex = 0;
    double stiffness = 0.0; ///< N/mm, > 0
};

struct Supports {
    std::vector<VertexId> fixed {}; ///< held where they are
    std::vector<BeddedVertex> bedded {}; ///< each at most once
};

/// A hook: nodes moved as one, a patch of wound surface and the bone it bears on. Never a single point: point supports
/// have no limit under refinement.
struct HookPatch {
    std::string name;
    int side = 0; ///< +1 or -1: the lip it holds
    std::vector<VertexId> nodes;
    Vec3 displacement = Vec3::Zero(); ///< mm, prescribed for all nodes
};

struct OpeningOptions {
    Elasticity elasticity = Elasticity::corotational; ///< not bounded
    bool locking_free = false; ///< elements of four nodes as locking_free.h has them
    /// One per element, 1 = of this elasticity, the others linear and condensed; empty: all of them. No contact then.
    std::vector<std::uint8_t> near {};
    /// Where the far elements' own law would change the displacement (root mean square) or the largest hook force by
    /// more than this share, as one Newton step tells, all elements are made nonlinear.
    double far_tolerance = 0.01;
    int load_steps = 4; ///< hook displacement is applied in at least this many steps, none longer than 3 mm
    int max_newton_iterations = 40; ///< at the full displacement (near: 10 quasi-Newton ones each); before, <= 4 a step
    /// Residual force relative to the largest internal or external nodal force. On a thorax wall opened by 50 mm
    /// (77,000 elements) 1e-3 leaves the nodes 0.04 mm off (root mean square; 1.6 mm at the worst one) and hook forces
    /// 0.1 %, against 5e-5.
    double tolerance = 1e-4;
    std::optional<ContactOptions>
        contact {}; ///< of the wound with itself and with fixed surfaces; none: passes through
    Eigen::VectorXd load {}; ///< N, three per node, on all of the hooks' way; with `near`, on near ones; empty: none
    /// Raised with the hooks' way; none with `near`. Above what tissue can bear there is no equilibrium, and the
    /// message says up to which pressure there was one.
    std::vector<SurfacePressure> pressures {};
};

struct ElasticProblem;

enum class OpeningStatus {
    converged,
    inverted, ///< in equilibrium, but with elements inside out: no state that tissue can be in
    not_converged,
    cancelled,
};

/// What became of the linear elements of OpeningOptions::near.
struct LinearFarField {
    bool kept = true; ///< false: all elements are nonlinear in the answer
    double change
        = 0.0; ///< by which it was off, as OpeningOptions::far_tolerance has it; infinite: it turned them over
    double share = 1.0; ///< not kept: of the hooks' way that was made with it
    Points displacement_change {}; ///< kept: n x 3, mm, what the elements' own law would change, to first order
    std::vector<Vec3> hook_force_changes_N {}; ///< kept: the same
};

struct [[nodiscard]] OpeningResult {
    OpeningStatus status = OpeningStatus::converged;
    std::string message;
    Points displacement; ///< n x 3, mm, all nodes
    std::vector<Vec3> hook_forces_N; ///< per hook: the force the surgeon must apply
    std::vector<double> strain; ///< per element: largest principal Green-Lagrange strain (P2: element mean)
    double strain_p99 = 0.0; ///< 99th percentile by volume, outside elements that touch a hook patch
    int inverted_elements = 0; ///< elements with det F <= 0 anywhere it is evaluated
    double max_volume_ratio = 1.0; ///< largest det F
    double min_volume_ratio = 1.0;
    Contact::State contact; ///< where it was asked for
    double contact_overlap_mm = 0.0; ///< the deepest of surfaces that overlap at rest: it is kept
    std::optional<LinearFarField> far; ///< where elements were to be linear, and an equilibrium was found
    double residual = 0.0; ///< as in OpeningOptions::tolerance
    int newton_iterations = 0; ///< over all load steps
    double assemble_seconds = 0.0, factor_seconds = 0.0, solve_seconds = 0.0;
};

/// Holds the mesh's stiffness pattern and its symbolic factorisation; both are built when first needed. A further
/// open() starts from the last converged state (status converged), and with the same nodes held it keeps the ordering.
class Opening {
public:
    /// @param materials one per element label id: materials_of_label[label]; labels not met may be anything.
    /// @throws InputError on bad meshes, materials, supports, and on options that contradict each other.
    Opening(const TetMesh& mesh, std::span<const Material> material_of_label, Supports supports,
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

} // namespace retractor
