#include "ui/scene/arrange_scenes.h"

#include <utility>

namespace retractor::ui {

namespace {

    /// The place of the n-th of several scenes; its scene is empty.
    Viewport in_grid(std::size_t n, std::size_t count)
    {
        const std::size_t columns = count > 1 ? 2 : 1;
        const std::size_t rows = (count + columns - 1) / columns;
        const auto column = static_cast<double>(n % columns), row = static_cast<double>(n / columns);
        const bool alone = n % columns == 0 && n + 1 == count; // in the last row
        Viewport place;
        place.left = column / static_cast<double>(columns);
        place.right = alone ? 1.0 : (column + 1.0) / static_cast<double>(columns);
        place.top = 1.0 - row / static_cast<double>(rows);
        place.bottom = 1.0 - (row + 1.0) / static_cast<double>(rows);
        return place;
    }

    Viewport beside_large(std::size_t n, std::size_t count)
    {
        constexpr double kLarge = 2.0 / 3.0;
        Viewport place;
        if (n + 1 == count) {
            place.right = kLarge;
            return place;
        }
        const auto rows = static_cast<double>(count - 1), row = static_cast<double>(n);
        place.left = kLarge;
        place.top = 1.0 - row / rows;
        place.bottom = 1.0 - (row + 1.0) / rows;
        return place;
    }

} // namespace

std::vector<Viewport> arrange_scenes(
    const std::vector<Scene>& scenes, double width_px, double height_px, SceneLayout layout)
{
    std::vector<Viewport> viewports;
    for (std::size_t n = 0; n < scenes.size(); ++n) {
        Viewport viewport = layout == SceneLayout::one_large && scenes.size() > 2 ? beside_large(n, scenes.size())
                                                                                  : in_grid(n, scenes.size());
        viewport.scene = scenes[n];
        const double aspect
            = (viewport.right - viewport.left) * width_px / ((viewport.top - viewport.bottom) * height_px);
        if (viewport.scene.slices.size() == 1)
            viewport.scene.camera = camera_for_slice(viewport.scene.slices.front(), aspect);
        viewports.push_back(std::move(viewport));
    }
    return viewports;
}

} // namespace retractor::ui
