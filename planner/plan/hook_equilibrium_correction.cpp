#include "planner/plan/hook_equilibrium_correction.h"

#include "fem/statics/hook_drive.h"
#include "mesh/base/assert.h"

namespace retractor::planner {

HeldHooks held_hooks(const Approach& approach, const fem::ElasticProblem& problem, const fem::TissueModel& model,
    const Points& displacement, const std::vector<Vec3>& forces_N, const std::optional<fem::ContactOptions>& contact)
{
    HeldHooks held { .drives = drives_of(approach), .response = {}, .at = {}, .forces = {} };
    if (held.drives.empty())
        return held;
    RETRACTOR_ASSERT(forces_N.size() == problem.hooks.size() && held.drives.size() == problem.hooks.size());
    held.response = fem::hook_response(problem, model, displacement, contact);
    std::vector<Vec3> at;
    for (const fem::HookPatch& hook : problem.hooks)
        at.push_back(hook.displacement);
    held.at = fem::packed(at);
    held.forces = fem::packed(forces_N);
    return held;
}

bool correct_hook_equilibrium(const HeldHooks& held, WoundSolution& solution)
{
    if (held.drives.empty())
        return true;
    RETRACTOR_ASSERT(solution.hook_forces_N.size() == held.drives.size());
    const std::optional<fem::ReleasedHooks> released
        = fem::release_hooks(held.response, held.at, held.forces, fem::packed(solution.hook_forces_N), held.drives);
    if (!released)
        return false;
    const Eigen::VectorXd moved = held.response.displacement * released->way;
    const Points of_nodes = Eigen::Map<const Points>(moved.data(), moved.size() / 3, 3);
    solution.displacement += of_nodes.topRows(solution.displacement.rows()); // midpoints come last
    solution.hook_forces_N = fem::per_hook(released->forces);
    solution.hooks_mm = fem::per_hook(held.at + released->way);
    return true;
}

} // namespace retractor::planner
