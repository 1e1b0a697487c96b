#pragma once
// Adds shading that VTK does not have: mottled tissue, moist bumps, steel, the rim of a highlighted target.

#include "ui/scene/scene.h"

class vtkActor;

namespace retractor::ui {

void apply_look(vtkActor& actor, const Look& look, bool highlighted);

} // namespace retractor::ui
