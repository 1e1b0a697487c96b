#pragma once
// Distances from the planned incision, which is a polyline. Units mm; any frame, the same for all points.

#include "mesh/base/geometry.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace retractor {

/// Distance (mm) from `p` to a polyline; infinite when it has no point.
double polyline_distance(std::span<const Vec3> polyline, const Vec3& p);

/// Answers the same questions for many points of a box. The box is divided into blocks with known distances, so that
/// most questions need no search. Questions about points beyond the box are slower.
class CorridorDistance {
public:
    /// @param low, high corners of the box (mm) that holds most points
    CorridorDistance(std::vector<Vec3> polyline, const Vec3& low, const Vec3& high);

    /// The result of polyline_distance(), to the last bit.
    double distance(const Vec3& p) const;
    /// Whether `p` lies within `radius` (mm): polyline_distance(...) <= radius, to the last bit.
    bool within(const Vec3& p, double radius) const;
    /// The result of share_within() for the polyline.
    double share(double radius, const Vec3& centre, const Vec3& edges, int samples) const;

    const std::vector<Vec3>& polyline() const { return polyline_; }

private:
    enum class Side { inside, outside, unknown };
    Side side(const Vec3& p, double radius, double reach) const;
    std::optional<std::size_t> block_of(const Vec3& p) const;
    void add_block(const Vec3& centre);

    std::vector<Vec3> polyline_;
    Vec3 low_;
    std::array<int, 3> blocks_ { 0, 0, 0 };
    std::vector<double> distance_; ///< distance of each block's centre from the polyline (mm)
    /// Per block, as a range of segments_: the segments that may be the nearest to a point of the block.
    std::vector<std::int32_t> first_segment_ { 0 }, segments_;
};

/// Share (0 to 1) of a box that lies within `radius` (mm) of the polyline. The box is given by its centre and its full
/// edge lengths along the axes. The function samples `samples`^3 points when the border may cross the box.
double share_within(std::span<const Vec3> polyline, double radius, const Vec3& centre, const Vec3& edges, int samples);

} // namespace retractor
