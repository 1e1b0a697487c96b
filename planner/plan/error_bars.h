#pragma once
// How far the numbers of a plan may be off: what finer elements would change in opening and forces. Where hooks are
// driven it is what they would change once the hooks have moved to where they rest in them. Units mm, N.

#include "planner/plan/opened_wound.h"

namespace retractor::planner {

/// Fills field.metrics.error; where there is no estimate that says why. Nothing here can undo the plan, but
/// cancelling it.
void estimate_errors(PlannedField& field, const OpenedWound& wound, const SolverSettings& choice, const Job& job);

} // namespace retractor::planner
