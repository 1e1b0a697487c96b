#pragma once
// The data that goes into and comes out of opening a wound: how it is solved (OpeningOptions) and what was found
// (OpeningResult). opening.h opens a wound; near_opening.h does the part of it in which tissue far from the wound stays
// linear. Units mm, N, MPa; frame patient LPS.

#include "fem/material/elasticity.h"
#include "fem/model/contact.h"
#include "fem/model/loads.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <Eigen/Core>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace retractor::fem {

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

} // namespace retractor::fem
