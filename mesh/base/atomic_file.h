#pragma once
// Files appear whole or not at all: written under a temporary name beside the target, flushed to disk, then renamed.
// A temporary file is hidden (".case.retractor-<process>-<n>.json") and locked by its writer; what a writer that was
// killed left behind is removed by the next one in that folder. Files that a library puts beside the temporary file,
// named after it, are removed with it.

#include <filesystem>
#include <functional>
#include <string_view>

namespace retractor {

/// Writes `content` to `path`, replacing what was there.
/// @throws IoError naming the path and the system's reason when any step fails; the old file is then untouched, except
/// when the message says that the new one is in place: then only its name could not be flushed to disk.
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

/// For libraries that write by file name: `write` is given a temporary path (same folder, same
/// extension, all of ".nii.gz") and the result is renamed to `path`. The temporary file is removed when `write` throws.
/// @throws IoError as above.
void write_file_atomically(
    const std::filesystem::path& path, const std::function<void(const std::filesystem::path& temporary)>& write);

} // namespace retractor
