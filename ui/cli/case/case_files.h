#pragma once
// Making a case folder out of images that may lie anywhere, and saying what was found.

#include "planner/case/import_case.h"
#include "ui/cli/framework/command.h"

#include <filesystem>

namespace retractor::ui::cli {

/// read_import() and write_import() of one CT with one label map.
/// @throws InputError, IoError; SolverError when the job was cancelled.
planner::Case make_case(const std::filesystem::path& ct, const std::filesystem::path& labels,
    const std::filesystem::path& case_file, const Job& job);

/// Series, grids, values, labels with volumes and pieces, structures, notes and warnings: what --json prints.
Json import_document(const planner::ImportedCase& imported);
/// The same for people.
std::string import_text(const planner::ImportedCase& imported);

Json series_document(const std::vector<datasets::DicomSeries>& series);
std::string series_text(const std::vector<datasets::DicomSeries>& series);

} // namespace retractor::ui::cli
