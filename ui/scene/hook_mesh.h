#pragma once
// The shape of a retractor hook.

#include "ui/scene/scene.h"

namespace retractor::ui {

/// A closed ribbon of steel: the patch against the lip, the bend over the wound's edge, the shaft away from it.
/// mm, in the frame of the item; oriented outwards. @throws InputError as check_scene does.
TriMesh hook_mesh(const HookItem& hook);

} // namespace retractor::ui
