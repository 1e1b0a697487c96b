#pragma once
// Pictures without a window: scene in, pixels out.

#include "mesh/base/job.h"
#include "ui/scene/scene.h"
#include "ui/scene/vtk/chart.h"
#include "ui/scene/vtk/offscreen.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

namespace retractor::ui {

/// Red, green, blue per pixel; the first row is the top one.
struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};

/// How many pixels of the target a view shows, and how many it would show with everything else removed.
struct TargetPixels {
    std::size_t visible = 0, unobstructed = 0;
    double share() const
    {
        return unobstructed == 0 ? 0.0 : static_cast<double>(visible) / static_cast<double>(unobstructed);
    }
};

/// Keeps what pictures have in common (shaders, uploaded volumes) between calls.
class OffscreenRenderer {
public:
    /// Records the part "renderer", and "volume rendering" when an image is first uploaded.
    explicit OffscreenRenderer(std::unique_ptr<OffscreenContext> context, const Job& job = {});
    ~OffscreenRenderer();
    OffscreenRenderer(OffscreenRenderer&&) noexcept;
    OffscreenRenderer& operator=(OffscreenRenderer&&) noexcept;

    /// @throws InputError as check_picture does; IoError when the drawing library reports an error: a picture
    /// with an error is never returned.
    Image render(const Picture& picture);

    /// @throws InputError when there is nothing to draw; IoError as above.
    Image render(const ChartPicture& picture);

    /// Counts pixels of surfaces marked `target`, with the surfaces marked `occluder` and the hooks before them;
    /// volumes, lines and slices do not count. @throws as render().
    TargetPixels target_pixels(const Scene& scene, int width = 1280, int height = 960);

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Writes atomically. @throws IoError naming the path; InputError on an empty image.
void write_png(const std::filesystem::path& path, const Image& image);
/// @throws IoError naming the path when it is no readable PNG.
Image read_png(const std::filesystem::path& path);

/// Peak signal to noise ratio (dB) of two images of one size; infinite when they are equal.
/// @throws InputError when the sizes differ.
double psnr_db(const Image& a, const Image& b);

} // namespace retractor::ui
