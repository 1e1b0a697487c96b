#pragma once
// Opens the case of a command.

#include "planner/case/case.h"

#include <string>

namespace retractor::ui::cli {

/// Reads the case with read_case() and verifies its checksums. An error names the file and the place in it:
/// "case.json#/labels/sha256".
/// @throws InputError, IoError
planner::Case open_case(const std::string& path);

} // namespace retractor::ui::cli
