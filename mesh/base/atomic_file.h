#pragma once
// Writes files atomically: a file appears whole or not at all. The content goes into a temporary file beside the
// target, is flushed to disk, and is then renamed to the target. A temporary file is hidden
// (".case.retractor-<process>-<n>.json") and locked by its writer. The next writer in the folder removes temporary
// files of writers that were killed. Files that a library puts beside the temporary file, named after the temporary
// file, are removed with it.

#include <filesystem>
#include <functional>
#include <string_view>

namespace retractor {

/// Writes `content` to `path` and replaces an existing file.
/// @throws IoError naming the path and the system's reason when a step fails. The old file is then untouched, with one
/// exception: the message may say that the new file is in place and only its name could not be flushed to disk.
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

/// The same for libraries that write by file name. `write` gets a temporary path in the same folder and with the same
/// extension (all of ".nii.gz"); the finished file is renamed to `path`. The temporary file is removed when `write`
/// throws.
/// @throws IoError as above.
void write_file_atomically(
    const std::filesystem::path& path, const std::function<void(const std::filesystem::path& temporary)>& write);

} // namespace retractor
