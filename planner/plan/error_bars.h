#pragma once
// Estimates the discretisation error of a plan: the change of opening and forces by finer elements. Driven hooks are
// first moved to their equilibrium in the finer elements (hook_equilibrium_correction.h). Units mm, N.

#include "planner/plan/opened_wound.h"

namespace retractor::planner {

/// Computes the error bars, or the reason why there are none (ErrorBars::message). A failed estimate does not change
/// the plan and throws no Error.
/// @param field the opened and measured field; @param wound the result of open_wound() for this field
ErrorBars estimate_errors(
    const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice, const Job& job);

} // namespace retractor::planner
