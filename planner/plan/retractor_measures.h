#pragma once
// The numbers of the retractor that holds a planned field open. Units mm, N, N m, degrees; frame patient LPS.

#include "planner/measures/field_metrics.h"
#include "planner/plan/planned_field.h"

#include <optional>

namespace retractor::planner {

/// Forces, moments and turns of the blades, and how far each lip follows its blade; nothing without a retractor.
/// @pre the field's wound is opened
std::optional<RetractorMetrics> retractor_metrics(const PlannedField& field);

} // namespace retractor::planner
