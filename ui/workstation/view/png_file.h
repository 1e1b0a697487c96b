#pragma once
// Writes the picture of a window to disk.

#include <filesystem>

class QImage;

namespace retractor::ui {

/// Replaces the file in one step. @throws IoError naming the path
void write_png_file(const std::filesystem::path& path, const QImage& image);

} // namespace retractor::ui
