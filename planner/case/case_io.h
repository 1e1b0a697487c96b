#pragma once
// Reads and writes case.json: schema 1, frame LPS, keys that carry their units. Reading refuses unknown keys.

#include "planner/case/case.h"

#include <filesystem>
#include <string>

namespace retractor::planner {

/// The schema number. The number grows when a case of the last schema cannot be read any more or changes its meaning.
/// An optional new key leaves the number unchanged when a case without the key keeps its meaning.
inline constexpr int kCaseSchema = 1;

/// SHA-256 (hexadecimal) of a file's content. The checksum of a folder is the SHA-256 of the sorted list of its files'
/// relative names and checksums.
/// @throws IoError when a file cannot be read
std::string checksum(const std::filesystem::path& path);

/// A reference to a file or folder inside the case folder, with its checksum computed.
/// @throws InputError when the file lies outside the folder; IoError when it cannot be read
FileReference make_reference(const std::filesystem::path& case_folder, const std::filesystem::path& path);

struct ReadCaseOptions {
    /// Compare the images and labels with the checksums of the case; this reads them once.
    bool verify_checksums = true;
};

/// @param path a case file, or a folder with a case.json
/// @throws IoError when the file cannot be read; InputError with the JSON pointer ("/approaches/0/depth_mm") in where()
/// on bad JSON, unknown or missing keys, wrong types, values out of range, implausible values (plausible_input.h),
/// duplicate names, and missing or changed files
Case read_case(const std::filesystem::path& path, const ReadCaseOptions& options = {});

/// Writes the case file Case::file() in one step: the file is complete or unchanged. Numbers keep their last bit.
/// @throws InputError as check_case() and check_plausible() do; IoError
void write_case(const Case& planned_case);

/// The text of case.json, and the case of a text. Neither looks at files.
std::string case_to_json(const Case& planned_case);
Case case_from_json(const std::string& text, const std::filesystem::path& folder);

/// The text of one entry of an approach's "ablations".
std::string ablation_to_json(const AblationSpec& ablation);

} // namespace retractor::planner
