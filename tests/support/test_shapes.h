#pragma once
// Closed surfaces that the tests of spheres fill and press.

#include "mesh/base/geometry.h"

namespace retractor::test_support {

/// A box, corner to corner, two triangles a side.
TriMesh box_surface(const Vec3& low, const Vec3& high);
/// A ball of about 2 * rings^2 triangles. @pre rings >= 2
TriMesh ball_surface(const Vec3& centre, double radius, int rings);

} // namespace retractor::test_support
