#pragma once
// A cheaper copy of a scene, to be drawn while the camera or the wound moves. Units mm.

#include "ui/scene/scene.h"

#include <cstddef>

namespace retractor::ui {

/// A line round which a surface is drawn more finely: what lies in the middle of the picture.
struct FineLine {
    Vec3 point = Vec3::Zero();
    Vec3 direction = Vec3::UnitZ(); ///< unit
    double radius_mm = 0.0; ///< beyond it the cubes are kCoarserFactor times as large; 0: they are alike everywhere
};
inline constexpr double kCoarserFactor = 2.0;

/// Merges the vertices within each cube of a grid that face the same octant into their mean, and drops the triangles
/// that collapse [Rossignac, Borrel 1993: Multi-resolution 3D approximations for rendering complex scenes]. The two
/// sides of a sheet face different octants, and so do not fall together. Triangles keep their labels. The surface moves
/// by at most a cube's diagonal. VTK's vtkQuadricClustering keeps the shape better, but takes ten times as long (0.1 s
/// for 400,000 triangles), and the window waits for this.
/// @throws InputError on a size that is not positive, or coordinates that are not finite
TriMesh clustered(const TriMesh& surface, double cube_mm, const FineLine& fine = {});

inline constexpr double kFineRadiusMm = 90.0; ///< holds a wound

/// The scene with about as many triangles as asked or fewer, clustered more finely within kFineRadiusMm of the camera's
/// line of sight, and without procedural textures. Everything else stays.
Scene moving_scene(Scene scene, std::size_t triangles);

} // namespace retractor::ui
