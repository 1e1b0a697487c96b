#pragma once
// Describes an import: its series, grids, labels, notes and warnings.

#include "planner/case/import_case.h"
#include "ui/cli/framework/command.h"

#include <filesystem>

namespace retractor::ui::cli {

/// The document of --json: series, grids, values, labels with volumes and pieces, structures, notes and warnings.
Json import_document(const planner::ImportedCase& imported);
/// The same findings as text for people.
std::string import_text(const planner::ImportedCase& imported);

Json series_document(const std::vector<datasets::DicomSeries>& series);
std::string series_text(const std::vector<datasets::DicomSeries>& series);

} // namespace retractor::ui::cli
