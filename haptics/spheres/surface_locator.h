#pragma once
// Queries of a closed triangle surface: whether a point is inside, the distance to the surface, and the nearest surface
// point. Units mm.

#include "mesh/base/geometry.h"

#include <array>
#include <cstddef>
#include <vector>

namespace retractor::haptics {

struct NearestOnSurface {
    std::size_t triangle = 0;
    Vec3 weights = Vec3::Zero(); ///< barycentric weights of the triangle's corners: each >= 0, sum 1
    Vec3 point = Vec3::Zero();
    double distance = 0.0; ///< mm
};

/// The point of the triangle nearest to p.
NearestOnSurface nearest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);
/// The nearest surface point by a test of every triangle, for surfaces that move. @pre the surface has triangles
NearestOnSurface nearest_on_surface(
    const Vec3& p, const Points& vertices, const std::vector<std::array<VertexId, 3>>& triangles);

/// Volume inside a closed surface, mm^3; positive when the surface is oriented outwards.
double enclosed_volume(const Points& vertices, const std::vector<std::array<VertexId, 3>>& triangles);

class SurfaceLocator {
public:
    /// @throws InputError on no triangles, indices out of range, coordinates that are not finite, or an edge without
    /// exactly one triangle on each side (an open or torn surface has no inside)
    explicit SurfaceLocator(const TriMesh& surface);

    bool inside(const Vec3& p) const;
    /// Whether a surface point is nearer to p than `distance`.
    bool is_near(const Vec3& p, double distance) const { return distance_within(p, distance) < distance; }
    /// Distance to the surface (mm), or `most` when the distance is larger.
    double distance_within(const Vec3& p, double most) const;

    const Vec3& low() const { return low_; }
    const Vec3& high() const { return high_; }

private:
    std::array<int, 3> cell_of(const Vec3& p) const;

    TriMesh surface_;
    Vec3 low_ = Vec3::Zero(), high_ = Vec3::Zero();
    double cell_ = 1.0;
    std::array<int, 3> size_ { 1, 1, 1 };
    std::vector<std::vector<std::int32_t>> cells_; ///< triangles whose box meets the cell
    std::vector<std::vector<std::int32_t>> columns_; ///< triangles whose box meets the column along z
};

} // namespace retractor::haptics
