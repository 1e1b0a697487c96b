#pragma once
// Making a case folder out of images that may lie anywhere, and saying what was found.

#include "planner/case/import_case.h"
#include "ui/cli/framework/command.h"

#include <filesystem>

namespace retractor::cli {

/// read_import() and write_import() of one CT with one label map.
/// @throws InputError, IoError; SolverError when the job was cancelled.
Case make_case(const std::filesystem::path& ct, const std::filesystem::path& labels,
    const std::filesystem::path& case_file, const Job& job);

/// Series, grids, values, labels with volumes and pieces, structures, notes and warnings: what --json prints.
Json import_document(const ImportedCase& imported);
/// The same for people.
std::string import_text(const ImportedCase& imported);

Json series_document(const std::vector<DicomSeries>& series);
std::string series_text(const std::vector<DicomSeries>& series);

} // namespace retractor::cli
