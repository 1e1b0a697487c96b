#pragma once
// case.json: schema 1, frame LPS, keys that carry their units. Reading refuses whatever it does not know.

#include "planner/case/case.h"

#include <filesystem>
#include <string>

namespace retractor::planner {

/// Counts up whenever a case of the schema before could not be read any more, or would mean something else. A key that
/// may be left out, and then means what there was before the key, leaves the schema as it is.
inline constexpr int kCaseSchema = 1;

/// SHA-256 (hexadecimal) of a file's content; of a folder: of the sorted list of its files' relative names and
/// checksums.
/// @throws IoError when something cannot be read.
std::string checksum(const std::filesystem::path& path);

/// A reference to a file or folder inside the case folder, with its checksum computed.
/// @throws InputError when it lies outside; IoError when it cannot be read.
FileReference make_reference(const std::filesystem::path& case_folder, const std::filesystem::path& path);

struct ReadCaseOptions {
    bool verify_checksums = true; ///< read images and labels once to see that they are the ones the case was planned on
};

/// @param path a case file, or a folder with a case.json.
/// @throws IoError when it cannot be read; InputError with the JSON pointer ("/approaches/0/depth_mm") in where() on
/// bad JSON, unknown or missing keys, wrong types, values out of range, duplicate names, missing or changed files.
Case read_case(const std::filesystem::path& path, const ReadCaseOptions& options = {});

/// Writes the case file, Case::file(), whole or not at all; numbers survive to the last bit.
/// @throws InputError as check_case does; IoError.
void write_case(const Case& planned_case);

/// The text of case.json, and back (files are not looked at).
std::string case_to_json(const Case& planned_case);
Case case_from_json(const std::string& text, const std::filesystem::path& folder);

/// The text of one entry of an approach's "ablations".
std::string ablation_to_json(const AblationSpec& ablation);

} // namespace retractor::planner
