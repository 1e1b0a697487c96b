#pragma once
// What a window shows, on disk.

#include <filesystem>

class QImage;

namespace retractor::ui {

/// Replaces what was there, atomically. @throws IoError naming the path.
void write_png_file(const std::filesystem::path& path, const QImage& image);

} // namespace retractor::ui
