#pragma once

#include <filesystem>

namespace retractor::datasets {

/// An upper bound of how deep sequences lie in each other; counting stops at `limit`. The parser calls itself for
/// every level, so that a file of nothing but nested sequences would use up the stack. Exact for well-formed files;
/// from the first place on that is not, every item is taken to lie in the one before, wherever its bytes are found.
int dicom_nesting(const std::filesystem::path& path, int limit);

/// Whether a file must not be given to the parser: structured reports nest some ten deep, this allows 64.
bool nests_too_deep(const std::filesystem::path& path);

} // namespace retractor::datasets
