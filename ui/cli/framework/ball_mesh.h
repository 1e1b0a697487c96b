#pragma once
// Balls as triangles: fingertips and the spheres inside an organ.

#include "mesh/base/geometry.h"

namespace retractor::ui::cli {

/// An icosahedron, each triangle divided into four `divisions` times, on a sphere. @pre 0 <= divisions <= 6
TriMesh ball_mesh(const Vec3& centre, double radius, int divisions);

/// Many of one size in one mesh.
TriMesh ball_meshes(const Points& centres, double radius, int divisions);

} // namespace retractor::ui::cli
