#pragma once
// Corners, area and normal of a triangle whose corners run counter-clockwise seen from outside. Units mm and mm^2.

#include "mesh/base/geometry.h"

#include <Eigen/Geometry>

#include <array>

namespace retractor {

/// The corners of a triangle over a point set.
inline std::array<Vec3, 3> triangle_corners(const Points& points, const std::array<VertexId, 3>& corners)
{
    return { point_at(points, corners[0]), point_at(points, corners[1]), point_at(points, corners[2]) };
}

/// Vector along the outward normal whose length is the area (mm^2).
inline Vec3 area_vector(const Vec3& a, const Vec3& b, const Vec3& c) { return 0.5 * (b - a).cross(c - a); }
inline Vec3 area_vector(const std::array<Vec3, 3>& p) { return area_vector(p[0], p[1], p[2]); }
/// The same for a triangle over a point set. A face of a mesh: area_vector(mesh.vertices, face_vertices(mesh, face)).
inline Vec3 area_vector(const Points& points, const std::array<VertexId, 3>& corners)
{
    return area_vector(points.row(corners[0]), points.row(corners[1]), points.row(corners[2]));
}

inline double triangle_area(const Vec3& a, const Vec3& b, const Vec3& c) { return area_vector(a, b, c).norm(); }
inline double triangle_area(const std::array<Vec3, 3>& p) { return area_vector(p).norm(); }
inline double triangle_area(const Points& points, const std::array<VertexId, 3>& corners)
{
    return area_vector(points, corners).norm();
}

/// Outward unit normal; zero for a triangle without area.
inline Vec3 unit_normal(const Vec3& a, const Vec3& b, const Vec3& c) { return area_vector(a, b, c).normalized(); }
inline Vec3 unit_normal(const std::array<Vec3, 3>& p) { return area_vector(p).normalized(); }
inline Vec3 unit_normal(const Points& points, const std::array<VertexId, 3>& corners)
{
    return area_vector(points, corners).normalized();
}

} // namespace retractor
