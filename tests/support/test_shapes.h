#pragma once
// Closed surfaces for the tests that fill bodies with spheres and press them.

#include "mesh/base/geometry.h"

namespace retractor::test_support {

/// A box between two corners, with two triangles per side.
TriMesh box_surface(const Vec3& low, const Vec3& high);
/// A ball with about 2 * rings^2 triangles. @pre rings >= 2
TriMesh ball_surface(const Vec3& centre, double radius, int rings);

} // namespace retractor::test_support
