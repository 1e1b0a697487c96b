#pragma once
// Finds the triangles of a surface near a point with a uniform grid. The grid must be made anew after the triangles
// have moved; triangle_hierarchy.h follows them. Units mm.

#include "mesh/base/geometry.h"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace retractor::mesh {

struct ClosestPoint {
    Vec3 barycentric; ///< coordinates on the triangle; not negative, sum 1
    double distance = 0.0; ///< mm
};
/// The point of a triangle nearest to p (Ericson 2005, Real-Time Collision Detection, section 5.1.5). The triangle may
/// have no area.
ClosestPoint closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) noexcept;

class TriangleProximity {
public:
    /// @param reach largest distance of later searches (mm)
    /// @throws InputError when `reach` is not positive, or a vertex is out of range or not finite
    TriangleProximity(Points vertices, std::vector<std::array<VertexId, 3>> triangles, double reach);

    struct Nearby {
        std::int32_t triangle = 0;
        ClosestPoint point;
    };
    /// The triangles within `distance` (mm) of a point, the nearest first; at equal distance the lower number comes
    /// first.
    /// A distance above the reach counts as the reach.
    std::vector<Nearby> within(const Vec3& point, double distance) const;

private:
    std::array<std::int64_t, 3> cell(const Vec3& point) const;

    Points vertices_;
    std::vector<std::array<VertexId, 3>> triangles_;
    std::vector<Vec3> centroids_; ///< of each triangle
    std::vector<double> radii_; ///< of each triangle round its centroid, mm
    double reach_ = 0.0, size_ = 1.0;
    Vec3 origin_ = Vec3::Zero();
    std::vector<std::pair<std::uint64_t, std::int32_t>> cells_; ///< cell and triangle, ascending
};

} // namespace retractor::mesh
