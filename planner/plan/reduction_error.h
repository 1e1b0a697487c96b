#pragma once
// Estimates the error of a linear condensed region: the tissue far from the lips is solved as linear. Driven hooks are
// compared at their equilibrium in each solution. Units mm, N.

#include "planner/plan/opened_wound.h"

namespace retractor::planner {

/// Estimates, to first order, the change of opening and forces when the condensed region follows its nonlinear law. A
/// failed estimate leaves its reason in the message and throws no Error.
/// @pre field.opening.far
CondensedRegionMetrics estimate_condensed_region_error(
    const PlannedField& field, const OpenedWound& wound, const SolverSettings& choice);

/// Solves the whole wall with the nonlinear law of the region near the lips, and compares the lips. A failure leaves
/// its reason in the message and throws no Error.
WholeMetrics compare_with_whole(
    const PlannedField& field, const RigidPieces& rigid, const SolverSettings& choice, const Job& job);

} // namespace retractor::planner
