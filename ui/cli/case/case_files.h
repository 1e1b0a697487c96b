#pragma once
// Makes a case folder from images anywhere on disk, and describes the import.

#include "planner/case/import_case.h"
#include "ui/cli/framework/command.h"

#include <filesystem>

namespace retractor::ui::cli {

/// Calls read_import() and write_import() for one CT with one label map.
/// @throws InputError, IoError; SolverError when the job is cancelled
planner::Case make_case(const std::filesystem::path& ct, const std::filesystem::path& labels,
    const std::filesystem::path& case_file, const Job& job);

/// The document of --json: series, grids, values, labels with volumes and pieces, structures, notes and warnings.
Json import_document(const planner::ImportedCase& imported);
/// The same findings as text for people.
std::string import_text(const planner::ImportedCase& imported);

Json series_document(const std::vector<datasets::DicomSeries>& series);
std::string series_text(const std::vector<datasets::DicomSeries>& series);

} // namespace retractor::ui::cli
