#pragma once
// Draws scenes to pixels without a window.

#include "mesh/base/job.h"
#include "ui/scene/scene.h"
#include "ui/scene/scene_language.h"
#include "ui/scene/vtk/chart.h"
#include "ui/scene/vtk/offscreen.h"
#include "ui/scene/vtk/stereo.h"

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

/// Draws pictures, and keeps shared shaders and uploaded volumes between calls.
class OffscreenRenderer {
public:
    /// Records the part "renderer" in the ledger, and "volume rendering" when an image is first uploaded.
    explicit OffscreenRenderer(std::unique_ptr<OffscreenContext> context, const Job& job = {});
    ~OffscreenRenderer();

    /// Sets this for all further pictures of scenes. Off at first.
    void set_stereo(Stereo stereo);

    /// The language of the texts in all further pictures of scenes. English at first.
    void set_language(TextLanguage language);

    /// @throws InputError as check_picture() does; IoError when the drawing library reports an error. A picture with an
    /// error is never returned.
    Image render(const Picture& picture);

    /// Prepares scenes that draw() draws, so that each picture after the first costs only its drawing.
    /// @throws InputError as check_picture() does
    void show(const Picture& picture);
    /// Draws the scenes of the last show() from other places; render() ends them. @pre one camera for each viewport
    /// @throws IoError when the drawing library reports an error
    Image draw(const std::vector<Camera>& cameras);

    /// @throws InputError when there is nothing to draw; IoError as above
    Image render(const ChartPicture& picture);

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Writes the file in one step. @throws IoError naming the path; InputError on an empty image
void write_png(const std::filesystem::path& path, const Image& image);

} // namespace retractor::ui
