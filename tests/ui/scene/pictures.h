#pragma once
// What the picture tests share: one renderer for the whole program, and pixels by name.

#include "ui/scene/vtk/render.h"

namespace retractor::ui::samples {

struct Pixel {
    int r = 0, g = 0, b = 0;
};

/// Column from the left and row from the top, as fractions.
inline Pixel pixel(const Image& image, double across, double down)
{
    const auto x = static_cast<std::size_t>(across * (image.width - 1) + 0.5);
    const auto y = static_cast<std::size_t>(down * (image.height - 1) + 0.5);
    const std::size_t first = 3 * (y * static_cast<std::size_t>(image.width) + x);
    return { image.rgb[first], image.rgb[first + 1], image.rgb[first + 2] };
}

inline OffscreenRenderer& renderer()
{
    static OffscreenRenderer instance(make_offscreen_context());
    return instance;
}

inline Image draw(const Scene& scene, int width = 320, int height = 240)
{
    Picture picture { .width = width, .height = height, .viewports = {} };
    picture.viewports.push_back({ .scene = scene });
    return renderer().render(picture);
}

} // namespace retractor::ui::samples
