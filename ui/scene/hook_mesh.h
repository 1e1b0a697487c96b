#pragma once
// Makes the mesh of a retractor hook.

#include "ui/scene/scene.h"

namespace retractor::ui {

/// A closed ribbon of steel: the patch against the lip, the bend over the wound's edge, and the shaft away from the
/// wound. Units mm, in the frame of the item; triangles face outwards.
/// @throws InputError as check_scene() does
TriMesh hook_mesh(const HookItem& hook);

} // namespace retractor::ui
