#pragma once
// The asked and the reached accuracy of a plan: each number described once for metrics.json and the window, and one
// sentence for people. Units as stored: mm, s; fractions 0 to 1.

#include "planner/measures/field_metrics.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace retractor::planner {

/// Names in files: "reached", "time", "memory", "rounds", "failure".
std::string_view to_string(AccuracyEnd end);

enum class AccuracyUnit {
    percent, ///< the stored value is a fraction
    mm,
    s,
};

/// A number of AccuracyMetrics.
struct AccuracyField {
    const char* key; ///< key in metrics.json, group "accuracy"
    AccuracyUnit unit = AccuracyUnit::mm;
    const char* caption = ""; ///< heading of a row
    const char* meaning = ""; ///< meaning, in one sentence
    /// The number; nothing where it is not known.
    std::optional<double> (*of)(const AccuracyMetrics& accuracy) = nullptr;
};

/// All numbers in the order of the listings.
std::span<const AccuracyField> accuracy_fields();

/// A number with its unit as people read it: "9.1 %", "1.2 mm", "600 s".
std::string accuracy_number(const AccuracyField& field, double value);

/// A sentence or two for a surgeon: "The force is known to 9 % (asked: 15 %). The opening is known to 1.2 mm (asked:
/// 2 mm)." Empty when no accuracy was asked.
std::string accuracy_text(const FieldMetrics& field);

} // namespace retractor::planner
