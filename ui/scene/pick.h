#pragma once
// What a ray meets in a scene. Units mm; frame patient LPS.

#include "ui/scene/scene.h"

#include <optional>
#include <string>

namespace retractor::ui {

struct Picked {
    std::string name {}; ///< of the surface; empty: the face of the cut
    Vec3 place = Vec3::Zero();
    std::optional<Label> label {}; ///< of the triangle, or on the face of the cut; nothing: the surface has no labels
};

/// Surfaces fainter than this are looked through, where anything stands behind them.
inline constexpr double kLeastPickedOpacity = 0.5;

/// The nearest place at which a ray meets what the scene shows: a surface that can be seen, or the face of its cut.
/// @param direction unit
/// @returns nothing when the ray meets nothing
std::optional<Picked> pick(const Scene& scene, const Vec3& from, const Vec3& direction);

} // namespace retractor::ui
