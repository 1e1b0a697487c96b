#pragma once
// The places of several scenes in one picture.

#include "ui/scene/scene.h"

#include <vector>

namespace retractor::ui {

enum class SceneLayout {
    grid,
    one_large, ///< the last scene fills two thirds of the width on the left, the others stand in a column beside it
};

/// Arranges scenes in a grid: one scene fills everything; more fill rows of two from the top left, and the last of an
/// odd number fills its row. Slices are fitted.
std::vector<Viewport> arrange_scenes(
    const std::vector<Scene>& scenes, double width_px, double height_px, SceneLayout layout = SceneLayout::grid);

} // namespace retractor::ui
