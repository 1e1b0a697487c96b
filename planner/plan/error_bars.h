#pragma once
// How far the numbers of a plan may be off: what finer elements would change in opening and forces. Where hooks are
// driven it is what they would change once the hooks have moved to where they rest in them. Units mm, N.

#include "planner/plan/opened_wound.h"

namespace retractor::planner {

/// The error bars, or the reason why there are none. An estimate that fails leaves the plan as it is.
ErrorBars estimate_errors(
    const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice, const Job& job);

} // namespace retractor::planner
