#pragma once

#include <filesystem>

namespace retractor {

/// How deep sequences lie in each other, up to the pixels; counting stops at `limit`. The parser calls itself for
/// every level, so that a file of nothing but nested sequences would use up the stack.
int dicom_nesting(const std::filesystem::path& path, int limit);

} // namespace retractor
