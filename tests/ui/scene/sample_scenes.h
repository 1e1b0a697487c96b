#pragma once
// Small scenes for the tests of pictures.

#include "ui/scene/scene.h"

namespace retractor::ui::samples {

/// An axis-aligned box of a surface, oriented outwards.
TriMesh box_mesh(const Vec3& low, const Vec3& high, Label label = 1);
/// A sphere of `rings` rings of quadrilaterals.
TriMesh sphere_mesh(const Vec3& centre, double radius, int rings = 48);
/// One box of a plain colour, unlit, in front of a black background, without annotations.
Scene box_scene(const Vec3& low, const Vec3& high, const Color& color);
SurfaceItem unlit(TriMesh mesh, const Color& color);

/// A chest in miniature, 120 mm wide: a layered wall with an opening, two blades, a target, organs as a CT.
/// Everything a picture can hold.
Scene little_chest(bool with_volume = true);
/// The CT of little_chest, before its wall is hidden, and the wall's mask.
std::shared_ptr<const mesh::Volume> little_ct();
std::shared_ptr<const VoxelMask> little_wall_mask();

} // namespace retractor::ui::samples
