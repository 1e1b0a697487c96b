#pragma once
// Estimates the discretisation error of a plan: the change of opening, forces and visible share by finer elements.
// Driven hooks are first moved to their equilibrium in the finer elements (hook_equilibrium_correction.h). Units mm, N;
// shares 0 to 1.

#include "mesh/base/geometry.h"
#include "planner/plan/opened_wound.h"

#include <functional>

namespace retractor::planner {

/// The share of the target that is seen through the wound under a displacement of the wall's vertices, n x 3, mm: the
/// measure of FieldMetrics::seen_best_eye.
using SeenShare = std::function<double(const Points& displacement)>;

/// Computes the error bars, or the reason why there are none (ErrorBars::message). A failed estimate does not change
/// the plan and throws no Error.
/// @param field the opened and measured field; @param wound the result of open_wound() for this field
/// @param seen_share called once for each comparison solution
ErrorBars estimate_errors(const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice,
    const SeenShare& seen_share, const Job& job);

} // namespace retractor::planner
