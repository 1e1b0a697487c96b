#pragma once
// Corners, area and normal of a triangle whose corners run counter-clockwise seen from outside, and where a line meets
// it. Units mm and mm^2.

#include "mesh/base/geometry.h"

#include <Eigen/Geometry>

#include <array>
#include <optional>

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

/// Where a line meets a triangle.
struct LineHit {
    double distance = 0.0; ///< from the line's origin, in lengths of its direction; negative behind the origin
    double u = 0.0, v = 0.0; ///< weights of the second and third corner
};

/// Where a line meets a triangle, from either side [Moeller and Trumbore 1997]; nothing when the line passes by.
inline std::optional<LineHit> line_hit(const Vec3& origin, const Vec3& direction, const std::array<Vec3, 3>& p)
{
    const Vec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
    const Vec3 h = direction.cross(e2);
    const double determinant = e1.dot(h);
    if (determinant == 0.0)
        return std::nullopt;
    const Vec3 s = origin - p[0];
    const Vec3 g = s.cross(e1);
    const double u = s.dot(h) / determinant, v = direction.dot(g) / determinant;
    if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0))
        return std::nullopt;
    return LineHit { e2.dot(g) / determinant, u, v };
}

} // namespace retractor
