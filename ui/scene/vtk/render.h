#pragma once
// Draws scenes to pixels without a window.

#include "mesh/base/job.h"
#include "ui/scene/scene.h"
#include "ui/scene/vtk/chart.h"
#include "ui/scene/vtk/offscreen.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

namespace retractor::ui {

/// Red, green and blue of each pixel; the top row comes first.
struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};

/// Number of target pixels in a view, and their number when everything else is removed.
struct TargetPixels {
    std::size_t visible = 0, unobstructed = 0;
    double share() const
    {
        return unobstructed == 0 ? 0.0 : static_cast<double>(visible) / static_cast<double>(unobstructed);
    }
};

/// Draws pictures, and keeps shared shaders and uploaded volumes between calls.
class OffscreenRenderer {
public:
    /// Records the part "renderer" in the ledger, and "volume rendering" when an image is first uploaded.
    explicit OffscreenRenderer(std::unique_ptr<OffscreenContext> context, const Job& job = {});
    ~OffscreenRenderer();
    OffscreenRenderer(OffscreenRenderer&&) noexcept;
    OffscreenRenderer& operator=(OffscreenRenderer&&) noexcept;

    /// @throws InputError as check_picture() does; IoError when the drawing library reports an error. A picture with an
    /// error is never returned.
    Image render(const Picture& picture);

    /// @throws InputError when there is nothing to draw; IoError as above
    Image render(const ChartPicture& picture);

    /// Counts pixels of surfaces marked `target`. Surfaces marked `occluder` and the hooks hide them; volumes, lines
    /// and slices do not.
    /// @throws as render() does
    TargetPixels target_pixels(const Scene& scene, int width = 1280, int height = 960);

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Writes the file in one step. @throws IoError naming the path; InputError on an empty image
void write_png(const std::filesystem::path& path, const Image& image);
/// @throws IoError naming the path when the file is no readable PNG
Image read_png(const std::filesystem::path& path);

/// Peak signal to noise ratio (dB) of two images of the same size; infinite when they are equal.
/// @throws InputError when the sizes differ
double psnr_db(const Image& a, const Image& b);

} // namespace retractor::ui
