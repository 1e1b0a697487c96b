#pragma once
// Distances from a straight line between two points.

#include "mesh/base/geometry.h"

#include <algorithm>

namespace retractor {

/// Distance of a point from the segment between a and b. @pre a and b differ
inline double distance_to_segment(const Vec3& point, const Vec3& a, const Vec3& b)
{
    const Vec3 line = b - a;
    const double t = std::clamp((point - a).dot(line) / line.squaredNorm(), 0.0, 1.0);
    return (point - a - t * line).norm();
}

} // namespace retractor
