#pragma once
// Compares planned fields number by number, and says which leads beyond the error. Units as stored: mm, mm2, N.

#include "planner/measures/field_metrics.h"
#include "planner/measures/metric_table.h"

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// Whether the discretisation error of the field was estimated.
bool has_error_bars(const FieldMetrics& field);

/// Whether nothing speaks against the numbers of the field (why_not_to_use()). Another field leads in nothing.
bool is_solved(const FieldMetrics& field);

/// The error bar of the opening as a share of the opening; nothing without an estimate.
std::optional<double> relative_opening_bar(const FieldMetrics& field);

/// The error bar of a number, or of the number that it is at least as uncertain as; nothing when it is unknown.
std::optional<double> error_bar(const MetricField& metric, const FieldMetrics& field);

struct ComparedNumber {
    double value = 0.0; ///< as stored
    std::optional<double> bar {}; ///< its own error bar; nothing where it has none
};

/// One number of all fields.
struct ComparedMeasure {
    const MetricField* metric = nullptr;
    std::vector<ComparedNumber> numbers; ///< in the order of the fields
    /// The field that is better than every other by more than both error bars. Nothing when the lead is within the
    /// error, or the error is unknown.
    std::optional<std::size_t> leader {};
};

/// The numbers that are compared (MetricField::compared), in the order of the table. Where the fields have different
/// targets none leads in what is seen.
std::vector<ComparedMeasure> compared_measures(const std::vector<FieldMetrics>& fields);

/// +1 where the first field is better than the second by more than both error bars together, -1 where it is worse; 0
/// within the error, where the error is unknown, and where a field was not solved (is_solved()).
int lead_over(const MetricField& metric, const FieldMetrics& first, const FieldMetrics& second);

/// Whether all fields have the same target, at the same place.
bool have_one_target(const std::vector<FieldMetrics>& fields);

/// The sentence for people where they do not.
inline constexpr std::string_view kDifferentTargets
    = "The approaches have different targets, so what is seen of them is not compared.";

/// Whether the approach that shows most of the target still does when patient, organs or lungs lie otherwise than
/// assumed: one sentence for each condition under which another one shows most, or one sentence with the least and the
/// most that the same approach shows. Empty where the fields have different targets, fewer than two of them are solved,
/// none leads, or no condition was measured.
/// @param letters of the fields; empty: as compared_letter()
std::vector<std::string> sight_order_sentences(
    const std::vector<FieldMetrics>& fields, std::vector<std::string> letters = {});

/// What the shares of the target that are seen are shares of, for people.
inline constexpr std::string_view kSharesAreOf
    = "What the best eye sees is a share of what an eye would see with the wall removed; what the eyes of the cone see "
      "is a share of the target's whole area, and so may be smaller.";

/// Letter of the n-th field, the same in pictures and tables: "A", "B".
std::string compared_letter(std::size_t n);

} // namespace retractor::planner
