#pragma once
// What a linear far field changes in a plan: the tissue far from the lips solved as linear. Driven hooks are let go:
// they rest where they would in what is compared with. Units mm, N.

#include "planner/plan/opened_wound.h"

namespace retractor::planner {

/// The error of a linear condensed region, by the law of the tissue there. @pre field.opening.far.
CondensedRegionMetrics estimate_condensed_region_error(
    const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice);

/// With all of the wall solved as it is near the lips.
WholeMetrics compare_with_whole(
    const PlannedField& field, const RigidPieces& rigid, const SolverSettings& choice, const Job& job);

} // namespace retractor::planner
