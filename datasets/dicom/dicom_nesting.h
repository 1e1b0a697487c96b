#pragma once

#include <filesystem>

namespace retractor::datasets {

/// Returns an upper bound of the depth of nested sequences; counting stops at `limit`. The DICOM parser calls itself
/// for every level, so a file of nested sequences could exhaust the stack. The bound is exact for well-formed files.
/// After the first violation of the standard, every item counts as nested in the item before.
int dicom_nesting(const std::filesystem::path& path, int limit);

/// True when a file must not be given to the parser, because its sequences nest 64 levels or more. Structured reports
/// have about ten levels.
bool nests_too_deep(const std::filesystem::path& path);

} // namespace retractor::datasets
