#pragma once
// Surfaces, lines and hooks as VTK actors.

#include "ui/scene/scene.h"

#include <vtkSmartPointer.h>

#include <vector>

class vtkActor;

namespace retractor::ui {

/// One actor per look that the surface has.
std::vector<vtkSmartPointer<vtkActor>> surface_actors(const SurfaceItem& item);
/// The whole surface in one unlit colour, every pixel of it the same.
vtkSmartPointer<vtkActor> flat_actor(const TriMesh& mesh, const Color& color);
vtkSmartPointer<vtkActor> line_actor(const LineItem& item, double picture_height_px);
vtkSmartPointer<vtkActor> hook_actor(const HookItem& item);

} // namespace retractor::ui
