#pragma once
// The places of several scenes in one picture.

#include "ui/scene/scene.h"

#include <vector>

namespace retractor::ui {

/// Arranges scenes in a grid: one scene fills everything; more fill rows of two from the top left, and the last of an
/// odd number fills its row. Slices are fitted.
std::vector<Viewport> arrange_scenes(const std::vector<Scene>& scenes, double width_px, double height_px);

} // namespace retractor::ui
