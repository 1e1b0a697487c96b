#pragma once
// Makes triangle meshes of balls, for fingertips and for the spheres inside an organ.

#include "mesh/base/geometry.h"

namespace retractor::ui::cli {

/// A sphere from an icosahedron; each triangle is divided into four `divisions` times. @pre 0 <= divisions <= 6
TriMesh ball_mesh(const Vec3& centre, double radius, int divisions);

/// Balls of one size in one mesh.
TriMesh ball_meshes(const Points& centres, double radius, int divisions);

} // namespace retractor::ui::cli
