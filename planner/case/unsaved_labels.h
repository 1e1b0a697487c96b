#pragma once
// Corrections of labels that are not saved yet, as a file beside the case: after a crash they are made again.

#include "planner/case/label_session.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace retractor::planner {

/// "case.unsaved-labels" beside "case.json".
std::filesystem::path unsaved_labels_file(const Case& planned_case);

/// A sum of voxels and names. Corrections fit only the labels that they were made on.
std::uint32_t sum_of(const mesh::LabelVolume& labels);

/// Writes the file in one step, or removes it where there are no steps. @throws IoError
void write_unsaved_labels(
    const std::filesystem::path& file, std::uint32_t sum_of_labels, const std::vector<LabelStep>& steps);

/// The steps of a file; nothing where there is no file.
/// @throws IoError; InputError when the file is damaged, or was made on other labels
std::optional<std::vector<LabelStep>> read_unsaved_labels(
    const std::filesystem::path& file, std::uint32_t sum_of_labels);

} // namespace retractor::planner
