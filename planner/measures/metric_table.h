#pragma once
// The single numbers of a planned field, each described once: metrics.json, the report, the window and the command line
// take their rows from this table. Units as stored: mm, mm2, N; fractions 0 to 1.

#include "planner/measures/field_metrics.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace retractor::planner {

/// What stands together in every listing.
enum class MetricGroup { sight, opening, distances, force, strain, soundness };

/// How people read a number.
enum class MetricUnit {
    percent, ///< of a stored fraction
    cm2, ///< of stored mm2
    mm,
    N,
    none,
};

/// How far a number may be off by the discretisation, which decides whether one approach leads another.
enum class MetricBar {
    unknown,
    estimated, ///< it has a bar of its own, where errors were estimated
    exact, ///< it does not depend on the discretisation
    of_opening, ///< it has none of its own, and is at least as uncertain as the opening it is seen through
};

struct MetricField {
    const char* key; ///< in metrics.json
    MetricGroup group = MetricGroup::sight;
    MetricUnit unit = MetricUnit::none;
    const char* caption = ""; ///< at the head of a row
    const char* meaning = ""; ///< one sentence
    double FieldMetrics::*member = nullptr;
    int better = 0; ///< +1: more is better, -1: less is better, 0: neither
    MetricBar bar = MetricBar::unknown;
    double ErrorBars::*error = nullptr; ///< of those that are estimated
    bool compared = false; ///< a row of the report's comparison

    double of(const FieldMetrics& field) const { return field.*member; }
};

/// All of them in the order of the listings: group by group.
std::span<const MetricField> metric_fields();
/// @pre the key is in the table.
const MetricField& metric_field(std::string_view key);

/// A number without its unit in the unit that people read: "62.3" of 0.623.
std::string metric_number(const MetricField& metric, double value, int digits = 1);
/// "62.3 %", "42.1 cm²", "57.9 mm", "41.3 N", "2.1".
std::string metric_text(const MetricField& metric, double value, int digits = 1);

/// The number's own error bar; none where it has none or errors were not estimated.
std::optional<double> metric_error(const MetricField& metric, const FieldMetrics& field);

} // namespace retractor::planner
