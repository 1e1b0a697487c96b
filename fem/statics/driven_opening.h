#pragma once
// Openings by hooks that do not simply go where they are told (hook_drive.h): drawn by a force, gripping softly, or
// yielding at a limit. The wound is opened with the hooks at some place; what they bear there, and the stiffness that
// the tissue shows them there (its tangent condensed onto the hooks), say where they go next: Newton's method in three
// unknowns per hook, each evaluation an opening. Linear tissue needs one, under loads two.
// Units mm, N.

#include "fem/statics/boundary_conditions.h"
#include "fem/statics/elastic_problem.h"
#include "fem/statics/hook_drive.h"
#include "fem/statics/opening_types.h"
#include "mesh/base/job.h"

#include <Eigen/Core>

#include <optional>
#include <span>
#include <vector>

namespace retractor::fem {

/// No wound is opened by more than this on a side: rib spreaders end at some 250 mm between their blades.
constexpr double kFarthestHookMm = 150.0;

/// What the tissue shows its hooks, to first order at some state, with everything else at rest.
struct HookResponse {
    Eigen::MatrixXd stiffness; ///< forces per mm of each hook: 3 hooks x 3 hooks, N/mm, symmetric
    Eigen::MatrixXd displacement; ///< of the body per mm of each hook: 3 nodes x 3 hooks
    /// What of the hooks' forces holds the body's loads (tension that a cut set free, pressure), N, three per hook;
    /// tissue that is stiffer everywhere leaves it as it is. Empty: there are no loads.
    Eigen::VectorXd of_loads {};
};

/// What touches at this state pushes back; what does not touch yet is not foreseen.
/// @param displacement n x 3, of a state that the body can be in. @throws InputError and SolverError as Opening does.
HookResponse hook_response(const ElasticProblem& problem, const TissueModel& model, const Points& displacement,
    const std::optional<ContactOptions>& contact = {});

/// Hooks that were held, let go.
struct HooksLetGo {
    Eigen::VectorXd way; ///< from where they were held, mm, three per hook
    Eigen::VectorXd forces; ///< where they come to rest, N
};

/// Where hooks go that are driven, when other equations (finer elements, another law far off) find other forces at them
/// while they are held where they rest by `forces`. Nothing where all drives simply prescribe their place. The
/// stiffness of the other equations is taken as this one by the ratio of the forces less those that hold the loads:
/// near the gape that tension makes by itself, hooks bear next to nothing, and its ratio says nothing. Exact for one
/// hook in linear tissue.
/// @param at where they are held; @param forces, other_forces three per hook, N.
/// @return none where the forces without the loads' differ by more than ten times or pull the other way: that is beyond
/// telling.
std::optional<HooksLetGo> let_go(const HookResponse& response, const Eigen::VectorXd& at, const Eigen::VectorXd& forces,
    const Eigen::VectorXd& other_forces, const std::vector<HookDrive>& drives);

struct DrivenOpening {
    OpeningResult opening; ///< not converged, and says why, where the hooks find no rest
    std::vector<HookPatch> hooks; ///< with the displacements at which they rest
    std::vector<bool> yielded; ///< per hook: its limit holds it back
    double last_step_mm = 0.0; ///< that Newton's method would still take: how far off the hooks are
    int openings = 0;
};

/// With OpeningOptions::near the far field stays linear until the hooks are at rest, or it turns elements over; where
/// it is given up then, or by the first opening, all is nonlinear from there on: it does not come and go between
/// openings.
/// Given up, with the force reached, is what draws hooks on where tissue cannot follow: stretched more than threefold
/// (strain_p99), or past kFarthestHookMm. All openings are one stage of the job's progress.
/// @param problem its hooks' displacements are not used. @param drives one per hook.
/// @throws InputError on a bad drive, naming its hook, a wrong number of them, or two hooks that share a node and are
/// not told to go to the same place; else as Opening does.
DrivenOpening open_driven(const ElasticProblem& problem, std::span<const HookDrive> drives,
    const OpeningOptions& options, const Job& job = {});

} // namespace retractor::fem
