#pragma once
// Driven hooks of a plan in answers by other equations (finer elements, another law far off). Those answers are found
// with the hooks held where the plan has them; there a hook that pulls with a force, yields or grips softly would rest
// somewhere else, and the opening with it. Units mm, N.

#include "fem/statics/driven_opening.h"
#include "planner/case/approach.h"
#include "planner/plan/opened_wound.h"

#include <optional>
#include <vector>

namespace retractor::planner {

/// The plan's hooks where they are held, and what the tissue shows them there.
struct HeldHooks {
    std::vector<fem::HookDrive> drives; ///< empty: all simply go where they are told, and there is nothing to let go
    fem::HookResponse response;
    Eigen::VectorXd at, forces; ///< three per hook; forces of the answer whose response it is
};

/// @param problem that was solved, its hooks where they are held; @param displacement at its nodes; @param forces_N
/// there, one per hook. @throws as hook_response().
HeldHooks held_hooks(const Approach& approach, const fem::ElasticProblem& problem, const fem::TissueModel& model,
    const Points& displacement, const std::vector<Vec3>& forces_N, const std::optional<fem::ContactOptions>& contact);

/// Moves an answer found with the hooks held to where they would rest in it.
/// @return false, and nothing done, where that cannot be told: let_go().
bool correct_hook_equilibrium(const HeldHooks& held, WoundAnswer& answer);

} // namespace retractor::planner
