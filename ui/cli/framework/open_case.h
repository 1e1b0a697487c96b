#pragma once
// The case a command is given.

#include "planner/case/case.h"

#include <string>

namespace retractor::cli {

/// read_case(), its checksums verified; a refusal names the file and the place in it: "case.json#/labels/sha256".
/// @throws InputError, IoError.
Case open_case(const std::string& path);

} // namespace retractor::cli
