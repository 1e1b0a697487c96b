#pragma once
// Reads a movie back, to compare it with what was written.

#include "ui/scene/vtk/render.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::test_support {

struct ReadVideo {
    std::string codec, format; ///< FFmpeg's names
    double frames_per_second = 0.0, seconds = 0.0;
    std::vector<ui::Image> frames;
};

/// Decodes all frames. @throws std::runtime_error when the file cannot be played
ReadVideo read_video(const std::filesystem::path& path);

/// Mean difference of the channels, of 255.
double mean_difference(const ui::Image& a, const ui::Image& b);

} // namespace retractor::test_support
