#pragma once
// Making a case folder out of images that may lie anywhere.

#include "mesh/base/job.h"
#include "planner/case.h"

#include <filesystem>

namespace retractor::cli {

/// Reads CT and labels, checks that they overlap, and writes case.json beside copies of them (ct.nrrd,
/// labels.nrrd: voxels and geometry only, no patient data). Images already inside the case folder are referred
/// to where they are, except DICOM series from elsewhere, which are always converted.
/// A spine that is not among the labels is left out of the supports: the border of the meshed region then holds alone.
/// @throws InputError, IoError.
Case make_case(const std::filesystem::path& ct, const std::filesystem::path& labels,
    const std::filesystem::path& case_file, const Job& job);

} // namespace retractor::cli
