#pragma once
// The numbers of planned fields as a table for other programs (RFC 4180): metrics.csv beside metrics.json, and the
// summary of a batch. One column per number of the table of metrics, and one per error bar.

#include <nlohmann/json.hpp>

#include <string>

namespace retractor::ui {

/// "approach,target,verdict,seen_best_eye,seen_best_eye_error,...": units as in metrics.json.
std::string metrics_csv_header();

/// The row of one approach of metrics.json. A number that the approach does not have leaves its cell empty.
std::string metrics_csv_row(const nlohmann::ordered_json& approach);

/// The row of an approach without numbers.
std::string metrics_csv_empty_row(const std::string& approach);

} // namespace retractor::ui
