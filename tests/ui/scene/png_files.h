#pragma once
// Reads pictures back and compares them.

#include "ui/scene/vtk/render.h"

#include <filesystem>

namespace retractor::ui::samples {

/// @throws IoError naming the path when the file is no readable PNG
Image read_png(const std::filesystem::path& path);

/// Peak signal to noise ratio (dB) of two images of the same size; infinite when they are equal.
/// @throws InputError when the sizes differ
double psnr_db(const Image& a, const Image& b);

} // namespace retractor::ui::samples
