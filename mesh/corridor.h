#pragma once
// The planned incision as a polyline with distances to it. Units mm; frame: whatever the points are in.

#include "mesh/geometry.h"

#include <span>
#include <vector>

namespace retractor {

/// Distance (mm) from `p` to a polyline; infinite when it has no point.
double polyline_distance(std::span<const Vec3> polyline, const Vec3& p);

/// Share (0 to 1) of a box, given by its centre and full edge lengths along the axes, that lies within
/// `radius` of the polyline; sampled at `samples`^3 points when the border may cross the box.
double share_within(std::span<const Vec3> polyline, double radius, const Vec3& centre, const Vec3& edges, int samples);

} // namespace retractor
