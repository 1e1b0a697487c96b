#pragma once
// The numbers of the side panel as words: what a surgeon reads first comes first.

#include "planner/case/approach.h"
#include "planner/measures/field_metrics.h"

#include <string>
#include <vector>

namespace retractor::ui {

struct MetricRow {
    std::string key, value;
    std::string meaning; ///< one sentence, shown on hovering; may be empty
    bool warning = false; ///< the number casts doubt on the result
};

struct MetricSection {
    std::string title;
    std::vector<MetricRow> rows;
};

/// Of a planned field.
std::vector<MetricSection> field_rows(const planner::FieldMetrics& field);
/// Of an approach that is not planned yet: what was asked for.
std::vector<MetricSection> approach_rows(const planner::Approach& approach);
/// One line for the list: "62 % seen, 41 N" once planned.
std::string field_summary(const planner::FieldMetrics& field);
std::string approach_summary(const planner::Approach& approach);

} // namespace retractor::ui
