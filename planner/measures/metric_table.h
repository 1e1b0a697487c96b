#pragma once
// The single numbers of a planned field, each described once. metrics.json, the report, the window and the command line
// take their rows from this table. Units as stored: mm, mm2, N; fractions 0 to 1.

#include "planner/measures/field_metrics.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace retractor::planner {

/// Numbers of one group stand together in every listing.
enum class MetricGroup { sight, opening, distances, force, strain, soundness };

/// The unit in which people read a number.
enum class MetricUnit {
    percent, ///< the stored value is a fraction
    cm2, ///< the stored value is in mm2
    degree,
    mm,
    N,
    sr,
    none,
};

/// The kind of error bar for the discretisation. The bar decides whether one approach is better than another.
enum class MetricBar {
    unknown,
    estimated, ///< has its own bar, when errors were estimated
    exact, ///< does not depend on the discretisation
    of_sight, ///< has no bar of its own, and is at least as uncertain as the opening and the best eye's share
    of_opening, ///< has no bar of its own, and is at least as uncertain as the opening
};

struct MetricField {
    const char* key; ///< key in metrics.json
    MetricGroup group = MetricGroup::sight;
    MetricUnit unit = MetricUnit::none;
    const char* caption = ""; ///< heading of a row
    const char* meaning = ""; ///< meaning, in one sentence
    double FieldMetrics::*member = nullptr;
    int better = 0; ///< +1: more is better, -1: less is better, 0: neither
    MetricBar bar = MetricBar::unknown;
    double ErrorBars::*error = nullptr; ///< error bar of an estimated number
    bool compared = false; ///< whether the report's comparison has a row for it

    double of(const FieldMetrics& field) const { return field.*member; }
};

/// All numbers in the order of the listings, group by group.
std::span<const MetricField> metric_fields();
/// @pre the key is in the table
const MetricField& metric_field(std::string_view key);

/// A number in the unit that people read, without the unit: "62.3" for 0.623.
std::string metric_number(const MetricField& metric, double value, int digits = 1);
/// A number with its unit: "62.3 %", "42.1 cm²", "57.9 mm", "41.3 N", "2.1".
std::string metric_text(const MetricField& metric, double value, int digits = 1);

/// The number's own error bar; nothing where there is none or errors were not estimated.
std::optional<double> metric_error(const MetricField& metric, const FieldMetrics& field);

} // namespace retractor::planner
