#pragma once
// Opens a wound with hooks whose displacement is not given (hook_drive.h): hooks that pull with a force, grip softly,
// or yield at a limit.
//
// The solution is Newton's method in three unknowns per hook; each evaluation is an opening. An opening with the hooks
// at some place gives the forces on the hooks and the stiffness of the tissue at the hooks (the tangent, condensed onto
// the hooks). Forces and stiffness give the next place. Linear tissue needs one evaluation, and two under loads. Units
// mm, N.

#include "fem/statics/boundary_conditions.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/hook_drive.h"
#include "fem/statics/opening_types.h"
#include "fem/statics/tissue_linearisation.h"
#include "mesh/base/job.h"

#include <Eigen/Core>

#include <optional>
#include <span>
#include <vector>

namespace retractor::fem {

/// Largest displacement of a hook (mm). Rib spreaders open to some 250 mm between their blades.
constexpr double kFarthestHookMm = 150.0;

/// Linearises the tissue at a state. Surfaces that touch at this state resist; surfaces that would touch later do not.
/// @param displacement n x 3, mm, a possible state of the body
/// @throws InputError and SolverError as Opening does
HookResponse hook_response(const ElasticProblem& problem, const TissueModel& model, const Points& displacement,
    const std::optional<ContactOptions>& contact = {});

/// The same linearisation for other motions of the held nodes, such as the turns of a blade. The columns of
/// HookResponse are then these motions.
/// @param motions one motion per column, three entries per node; zero at nodes without a hook
/// @throws as hook_response()
HookResponse motion_response(const ElasticProblem& problem, const TissueModel& model, const Points& displacement,
    const Eigen::MatrixXd& motions, const std::optional<ContactOptions>& contact = {});

/// The displacement and the forces of hooks that are released from a fixed place.
struct ReleasedHooks {
    Eigen::VectorXd way; ///< displacement from the fixed place, mm, three per hook
    Eigen::VectorXd forces; ///< forces on the hooks at their new place, N, three per hook
};

/// Predicts the equilibrium of driven hooks under other equations (finer elements, another law outside the nonlinear
/// region). The other equations were solved with the hooks fixed at their equilibrium under `forces`, and gave
/// `other_forces`. Hooks that all prescribe their displacement do not move.
///
/// The stiffness of the other equations is estimated as the given stiffness times a ratio: the other hook forces over
/// the own hook forces, both without the part that balances loads. This part is excluded, because hooks near the gape
/// that tension makes alone bear almost nothing. The estimate is exact for one hook in linear tissue.
/// @param at displacement at which the hooks are fixed, mm, three per hook
/// @param forces, other_forces N, three per hook
/// @return nothing when the ratio is above 10 or below 1/10, or the forces point the opposite way: no prediction is
/// possible
std::optional<ReleasedHooks> release_hooks(const HookResponse& response, const Eigen::VectorXd& at,
    const Eigen::VectorXd& forces, const Eigen::VectorXd& other_forces, const std::vector<HookDrive>& drives);

struct DrivenOpening {
    OpeningResult opening; ///< not converged, with a message, when the hooks find no equilibrium
    std::vector<HookPatch> hooks; ///< the hooks with their displacements at equilibrium
    std::vector<bool> yielded; ///< per hook: the force limit is reached
    double last_step_mm = 0.0; ///< length of the next Newton step: the distance of the hooks from equilibrium
    int openings = 0;
};

/// Opens the wound with driven hooks.
///
/// With OpeningOptions::near, the condensed region stays linear until the hooks are in equilibrium, unless elements
/// turn over. Where the linear region is given up, by the first opening or at equilibrium, all later openings are
/// nonlinear everywhere: the region does not change back between openings.
///
/// The search stops, with the force that was reached, where tissue cannot follow a hook: tissue stretched more than
/// threefold (strain_p99), or a hook beyond kFarthestHookMm. All openings are one stage of the job's progress.
/// @param problem the displacements of its hooks are not used
/// @param drives one per hook
/// @throws InputError naming the hook of a bad drive, on a wrong number of drives, on two hooks that share a node and
/// do not prescribe the same displacement, and as Opening does
DrivenOpening open_driven(const ElasticProblem& problem, std::span<const HookDrive> drives,
    const OpeningOptions& options, const Job& job = {});

} // namespace retractor::fem
