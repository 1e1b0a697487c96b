#pragma once
// The part of the report that says what one space higher or lower, or 20 mm along, would give.

#include "planner/measures/field_metrics.h"

#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace retractor::planner {

/// An approach beside a field's own.
struct ReportNeighbour {
    std::string where; ///< "one space higher"
    std::optional<FieldMetrics> field {}; ///< as planned; not set: it has no plan
    std::string missing {}; ///< why it has none
};

/// Writes a table for each field that has planned neighbours, and for the others why there are none; nothing where no
/// field has a neighbour. @param neighbours of each field
void write_neighbours(std::ostream& out, const std::vector<FieldMetrics>& fields,
    const std::vector<std::vector<ReportNeighbour>>& neighbours);

} // namespace retractor::planner
