#pragma once
// What it changes that a plan left something out: tissue far from the lips solved as linear, or not solved at all.
// Driven hooks are let go: they rest where they would in what is compared with. Units mm, N.

#include "planner/plan/opened_wound.h"

namespace retractor::planner {

/// What a linear far field is off, by the law of the tissue there: fills field.metrics.solution.far.
/// @pre field.opening.far.
void estimate_far_field_error(PlannedField& field, const OpenedWound& wound, const SolverSettings& choice);

/// What leaving out the rest of the wall may have changed: estimated, and measured where that was asked for. Fills
/// field.metrics.local. @pre field.metrics.local.
void estimate_localisation_error(PlannedField& field, const RigidPieces& rigid, const fem::OpeningOptions& options,
    const SubmodelOptions& plan, const Job& job);

/// With the whole wall, all of it solved as `options` have it near the lips.
WholeMetrics compare_with_whole(
    const PlannedField& field, const RigidPieces& rigid, const fem::OpeningOptions& options, const Job& job);

} // namespace retractor::planner
