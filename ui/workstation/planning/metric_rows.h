#pragma once
// The numbers of the side panel as text, in the order in which a surgeon reads them.

#include "planner/case/approach.h"
#include "planner/measures/field_metrics.h"
#include "planner/measures/verdict.h"

#include <string>
#include <vector>

namespace retractor::ui {

struct MetricRow {
    std::string key, value;
    std::string meaning; ///< one sentence for the tool tip; may be empty
    bool warning = false; ///< the number makes the result doubtful
};

struct MetricSection {
    std::string title;
    std::vector<MetricRow> rows;
    bool technical = false; ///< about the computation; shown where it is asked for
};

/// The rows of a planned field.
std::vector<MetricSection> field_rows(const planner::FieldMetrics& field);
/// The rows of an approach that is not planned yet: the requested values.
std::vector<MetricSection> approach_rows(const planner::Approach& approach);
/// "no hooks", "1 hook", "4 hooks".
std::string hooks_in_words(std::size_t count);
/// One line for the list: "62 % seen, 41 N" for a planned field.
std::string field_summary(const planner::FieldMetrics& field);
std::string approach_summary(const planner::Approach& approach);

/// The colour of a verdict's light as "#rrggbb", the same for those who do not tell red from green, and its word.
struct LightLook {
    const char* color;
    const char* word;
};
LightLook light_look(planner::Light light);

} // namespace retractor::ui
