#pragma once
// What VTK's own shading has no word for: mottled tissue, moist bumps, steel, the rim of a highlighted target.

#include "ui/scene/scene.h"

class vtkActor;

namespace retractor::ui {

void apply_look(vtkActor& actor, const Look& look, bool highlighted);

} // namespace retractor::ui
