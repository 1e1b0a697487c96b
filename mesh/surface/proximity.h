#pragma once
// Which triangles of a surface lie near a point: a uniform grid over the triangles as they stand, made anew when they
// have moved. The way in for contact (fem). Units mm.

#include "mesh/base/geometry.h"

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace retractor::mesh {

struct ClosestPoint {
    Vec3 barycentric; ///< on the triangle; not negative, sum 1
    double distance = 0.0; ///< mm
};
/// The point of the triangle nearest to p [Ericson, Real-time collision detection, 2005, ch. 5.1.5]; for triangles
/// without area as well.
ClosestPoint closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) noexcept;

class TriangleProximity {
public:
    /// @param reach the largest distance that will be asked for, mm.
    /// @throws InputError on a reach that is not positive, a vertex out of range or not finite.
    TriangleProximity(Points vertices, std::vector<std::array<VertexId, 3>> triangles, double reach);

    struct Nearby {
        std::int32_t triangle = 0;
        ClosestPoint point;
    };
    /// The triangles within `distance` <= reach of a point, the nearest first; of two as near, the lower number.
    std::vector<Nearby> within(const Vec3& point, double distance) const;

private:
    std::array<std::int64_t, 3> cell(const Vec3& point) const;

    Points vertices_;
    std::vector<std::array<VertexId, 3>> triangles_;
    double reach_ = 0.0, size_ = 1.0;
    Vec3 origin_ = Vec3::Zero();
    std::vector<std::pair<std::uint64_t, std::int32_t>> cells_; ///< cell and triangle, rising
};

} // namespace retractor::mesh
