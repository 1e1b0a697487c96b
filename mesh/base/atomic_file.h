#pragma once
// Files appear whole or not at all: written under a temporary name beside the target, then renamed.

#include <filesystem>
#include <functional>
#include <string_view>

namespace retractor {

/// Writes `content` to `path`, replacing what was there.
/// @throws IoError naming the path when any step fails; the old file is then untouched.
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

/// For libraries that write by file name: `write` is given a temporary path (same folder, same
/// extension) and the result is renamed to `path`. The temporary file is removed when `write` throws.
/// @throws IoError as above.
void write_file_atomically(const std::filesystem::path& path,
    const std::function<void(const std::filesystem::path& temporary)>& write);

} // namespace retractor
