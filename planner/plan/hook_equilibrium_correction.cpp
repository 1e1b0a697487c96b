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

bool correct_hook_equilibrium(const HeldHooks& held, WoundAnswer& answer)
{
    if (held.drives.empty())
        return true;
    RETRACTOR_ASSERT(answer.hook_forces_N.size() == held.drives.size());
    const std::optional<fem::ReleasedHooks> rest
        = fem::release_hooks(held.response, held.at, held.forces, fem::packed(answer.hook_forces_N), held.drives);
    if (!rest)
        return false;
    const Eigen::VectorXd moved = held.response.displacement * rest->way;
    const Points of_nodes = Eigen::Map<const Points>(moved.data(), moved.size() / 3, 3);
    answer.displacement += of_nodes.topRows(answer.displacement.rows()); // midpoints come last
    answer.hook_forces_N = fem::per_hook(rest->forces);
    answer.hooks_mm = fem::per_hook(held.at + rest->way);
    return true;
}

} // namespace retractor::planner
