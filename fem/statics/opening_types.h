#pragma once
// Options and result of opening a wound. opening.h opens a wound; near_opening.h implements the option `near`, in which
// tissue far from the wound stays linear. Units mm, N, MPa; frame patient LPS.

#include "fem/material/elasticity.h"
#include "fem/model/blade_contact.h"
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
    Elasticity elasticity = Elasticity::corotational; ///< not corotational_linear
    bool locking_free = false; ///< uses the four-node elements of locking_free.h
    /// One per element: 1 = with `elasticity`, 0 = linear and condensed. Empty: all elements have `elasticity`.
    /// Excludes contact.
    std::vector<std::uint8_t> near {};
    /// Largest relative error of the linear elements, in displacement (root mean square) or in the largest hook force,
    /// estimated by one Newton step with their own law. Above this limit all elements become nonlinear.
    double far_tolerance = 0.01;
    int load_steps = 4; ///< least number of steps of the hooks' motion; no step is longer than 3 mm
    /// Iterations at full displacement; with `near`, each counts as 10 quasi-Newton steps; intermediate states take at
    /// most 4.
    int max_newton_iterations = 40;
    /// Residual force relative to the largest internal or external nodal force. On a thorax wall opened by 50 mm
    /// (77,000 elements), 1e-3 leaves an error of 0.04 mm (root mean square; 1.6 mm at the worst node) and of 0.1 % in
    /// hook forces, compared with 5e-5.
    double tolerance = 1e-4;
    double energy_tolerance = 0.0; ///< as EquilibriumOptions::energy_tolerance
    /// Contact of the wound with itself and with fixed surfaces; none: surfaces pass through.
    std::optional<ContactOptions> contact {};
    /// Rigid blades that push (ElasticProblem::blades); not allowed with `near`.
    std::vector<BladeSurface> blades {};
    /// Loads, N, three per node, constant while the hooks move; with `near`, on near nodes only; empty: none.
    Eigen::VectorXd load {};
    /// Pressures, raised together with the hooks' motion; not allowed with `near`. Above the pressure that tissue can
    /// bear there is no equilibrium, and the message names the largest pressure that had one.
    std::vector<SurfacePressure> pressures {};
};

enum class OpeningStatus {
    converged,
    inverted, ///< in equilibrium, but with inverted elements: not a possible state of tissue
    not_converged,
    cancelled,
};

/// Outcome for the linear elements of OpeningOptions::near.
struct LinearCondensedRegion {
    bool kept = true; ///< false: all elements of the answer are nonlinear
    double change = 0.0; ///< relative error, as OpeningOptions::far_tolerance; infinite: elements turned over
    double share = 1.0; ///< when not kept: share of the hooks' motion that was computed with linear elements
    Points displacement_change {}; ///< when kept: n x 3, mm, first-order change under the elements' own law
    std::vector<Vec3> hook_force_changes_N {}; ///< when kept: the same change of the hook forces
};

/// An element that was made stiffer because it was turned over.
struct StiffenedElement {
    TetId tet = 0;
    double factor = 1.0; ///< on the stiffness of its material
};

struct [[nodiscard]] OpeningResult {
    OpeningStatus status = OpeningStatus::converged;
    std::string message;
    Points displacement; ///< n x 3, mm, all nodes
    std::vector<Vec3> hook_forces_N; ///< force that the surgeon must apply to each hook
    /// The parts of these forces at the nodes, N, three per node; zero at nodes without a hook. Empty with
    /// OpeningOptions::near.
    Eigen::VectorXd hook_nodal_forces_N {};
    std::vector<double> strain; ///< per element: largest principal Green-Lagrange strain (P2: element mean)
    double strain_p99 = 0.0; ///< 99th percentile by volume, outside elements that touch a hook patch or blade
    int inverted_elements = 0; ///< number of `inverted`
    std::vector<TetId> inverted {}; ///< elements with det F <= 0 at any evaluation point, ascending
    std::vector<StiffenedElement> stiffened {}; ///< with FrameOptions::may_stiffen, ascending
    /// Absolute changes by this, from the balance before to the answer: of the larger blade force, and of the distance
    /// between the blades. 0: none.
    double stiffening_changed_N = 0.0, stiffening_changed_mm = 0.0;
    double max_volume_ratio = 1.0; ///< largest det F
    double min_volume_ratio = 1.0; ///< smallest det F
    std::vector<double> volume_ratio; ///< per element: deformed volume over rest volume
    Contact::State contact; ///< filled when contact was requested
    double contact_overlap_mm = 0.0; ///< deepest overlap of surfaces at rest; the overlap remains
    std::vector<BladeBearing> blades {}; ///< one per blade of OpeningOptions::blades
    std::optional<LinearCondensedRegion>
        far; ///< filled when linear elements were requested and an equilibrium was found
    double residual = 0.0; ///< as OpeningOptions::tolerance
    int newton_iterations = 0; ///< sum over all load steps
    double assemble_seconds = 0.0, factor_seconds = 0.0, solve_seconds = 0.0;
};

} // namespace retractor::fem
