#pragma once
// The case a command is given.

#include "planner/case/case.h"

#include <string>

namespace retractor::ui::cli {

/// read_case(), its checksums verified; a refusal names the file and the place in it: "case.json#/labels/sha256".
/// @throws InputError, IoError.
planner::Case open_case(const std::string& path);

} // namespace retractor::ui::cli
