#pragma once
// Corrects solutions that the plan's solution is compared with (finer elements, another law in the condensed region).
// Such a solution is computed with the hooks fixed at their places in the plan. A hook that pulls with a force, yields
// or grips softly has its equilibrium elsewhere in the other solution, and the opening changes with the hook. Units mm,
// N.

#include "fem/statics/driven_opening.h"
#include "planner/case/approach.h"
#include "planner/plan/opened_wound.h"

#include <optional>
#include <vector>

namespace retractor::planner {

/// The plan's hooks at their fixed places, and the response of the tissue at these places.
struct HeldHooks {
    std::vector<fem::HookDrive> drives; ///< empty: all hooks prescribe their displacement; no correction is needed
    fem::HookResponse response;
    Eigen::VectorXd at; ///< displacement of the fixed hooks, mm, three per hook
    Eigen::VectorXd forces; ///< forces on the hooks in the solution that was linearised, N, three per hook
};

/// Linearises a solution for the correction.
/// @param problem the solved problem, with the hooks at their fixed places
/// @param displacement of the problem's nodes, n x 3, mm
/// @param forces_N forces on the hooks in this solution, one per hook
/// @param contact as in the solution; empty: without contact
/// @throws as fem::hook_response()
HeldHooks held_hooks(const Approach& approach, const fem::ElasticProblem& problem, const fem::TissueModel& model,
    const Points& displacement, const std::vector<Vec3>& forces_N, const std::optional<fem::ContactOptions>& contact);

/// Moves the hooks of a solution from their fixed places to their equilibrium, and changes displacement and forces to
/// first order.
/// @return false, without a change, when the equilibrium cannot be predicted (fem::release_hooks())
bool correct_hook_equilibrium(const HeldHooks& held, WoundSolution& solution);

} // namespace retractor::planner
