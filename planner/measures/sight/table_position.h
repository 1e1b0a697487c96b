#pragma once
// How the patient lies on the table, and what is seen then, in words.

#include "planner/measures/field_metrics.h"

#include <string>

namespace retractor::planner {

/// "supine", "with the left side up by 30 degrees", "lying on the right side".
/// @param left_side_up_deg as TurnedSight::left_side_up_deg
std::string position_words(double left_side_up_deg);

/// What the best eye sees in each position on the table; empty: not computed.
std::string turned_sight_text(const FieldMetrics& field);

} // namespace retractor::planner
