#include "ui/scene/arrange_scenes.h"

#include <utility>

namespace retractor::ui {

std::vector<Viewport> arrange_scenes(const std::vector<Scene>& scenes, double width_px, double height_px)
{
    std::vector<Viewport> viewports;
    const std::size_t columns = scenes.size() > 1 ? 2 : 1;
    const std::size_t rows = (scenes.size() + columns - 1) / columns;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        const auto column = static_cast<double>(i % columns), row = static_cast<double>(i / columns);
        Viewport viewport;
        viewport.left = column / static_cast<double>(columns);
        const bool alone = i % columns == 0 && i + 1 == scenes.size(); // in the last row
        viewport.right = alone ? 1.0 : (column + 1.0) / static_cast<double>(columns);
        viewport.top = 1.0 - row / static_cast<double>(rows);
        viewport.bottom = 1.0 - (row + 1.0) / static_cast<double>(rows);
        viewport.scene = scenes[i];
        const double aspect
            = (viewport.right - viewport.left) * width_px / ((viewport.top - viewport.bottom) * height_px);
        if (viewport.scene.slices.size() == 1)
            viewport.scene.camera = camera_for_slice(viewport.scene.slices.front(), aspect);
        viewports.push_back(std::move(viewport));
    }
    return viewports;
}

} // namespace retractor::ui
