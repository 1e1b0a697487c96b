#pragma once
// A cheaper copy of a scene, to be drawn while the camera or the wound moves. Units mm.

#include "ui/scene/scene.h"

#include <cstddef>

namespace retractor::ui {

/// Merges the vertices within each cube of a grid into their mean and drops the triangles that collapse [Rossignac,
/// Borrel 1993: Multi-resolution 3D approximations for rendering complex scenes]. Triangles keep their labels. The
/// surface moves by at most a cube's diagonal; what is thinner than a cube may vanish. VTK's vtkQuadricClustering keeps
/// the shape better, but takes ten times as long (0.1 s for 400,000 triangles), and the window waits for this.
/// @throws InputError on a size that is not positive, or coordinates that are not finite
TriMesh clustered(const TriMesh& surface, double cube_mm);

/// The scene with about as many triangles as asked or fewer, all clustered with one size of cube, and without
/// procedural textures. Everything else stays.
Scene moving_scene(Scene scene, std::size_t triangles);

} // namespace retractor::ui
