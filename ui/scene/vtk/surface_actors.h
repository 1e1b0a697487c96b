#pragma once
// Makes VTK actors of surfaces and lines.

#include "ui/scene/scene.h"

#include <vtkSmartPointer.h>

#include <vector>

class vtkActor;

namespace retractor::ui {

/// One actor per look of the surface.
std::vector<vtkSmartPointer<vtkActor>> surface_actors(const SurfaceItem& item);
vtkSmartPointer<vtkActor> line_actor(const LineItem& item, double picture_height_px);

} // namespace retractor::ui
