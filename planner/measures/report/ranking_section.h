#pragma once
// The parts of the report that help to decide: what to think of first, and the scores with a plot of what each approach
// shows against what it spares.

#include "planner/measures/field_metrics.h"

#include <ostream>
#include <string>
#include <vector>

namespace retractor::planner {

/// Writes crisis_check() of each field; nothing without fields.
/// @param divided_bones of each field; empty: not known
void write_crisis_check(std::ostream& out, const std::vector<FieldMetrics>& fields,
    const std::vector<std::vector<std::string>>& divided_bones);

/// Writes the scores with the default weights, and the plot; nothing with fewer than two fields that are ranked. Fields
/// of different targets have no score, and a sentence says so.
void write_ranking(std::ostream& out, const std::vector<FieldMetrics>& fields,
    const std::vector<std::vector<std::string>>& divided_bones);

} // namespace retractor::planner
