#pragma once
// Where files of one approach lie beside its case: freehand cuts, and plans.

#include <filesystem>
#include <string_view>

namespace retractor::planner {

/// CASE/KIND/APPROACH.EXTENSION for CASE/case.json, and CASE/NAME.KIND/APPROACH.EXTENSION for CASE/NAME.json, since
/// several cases may lie in one folder. In the approach's name every character other than a letter, a digit, '-' or '_'
/// becomes %XX.
/// @param kind of the files: "cuts", "plans"; @param extension with its dot
std::filesystem::path approach_file(const std::filesystem::path& case_file, std::string_view kind,
    std::string_view approach, std::string_view extension);

} // namespace retractor::planner
