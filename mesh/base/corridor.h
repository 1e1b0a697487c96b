#pragma once
// The planned incision as a polyline with distances to it. Units mm; frame: whatever the points are in.

#include "mesh/base/geometry.h"

#include <array>
#include <span>
#include <vector>

namespace retractor {

/// Distance (mm) from `p` to a polyline; infinite when it has no point.
double polyline_distance(std::span<const Vec3> polyline, const Vec3& p);

/// The same distance for many points of a box: space is divided into blocks whose distance is known, so that most
/// questions need no search. Points beyond the box are answered too, only slower.
class CorridorDistance {
public:
    /// @param low, high corners of the box that most points lie in.
    CorridorDistance(std::vector<Vec3> polyline, const Vec3& low, const Vec3& high);

    /// Whether `p` lies within `radius` (mm): polyline_distance(...) <= radius, to the last bit.
    bool within(const Vec3& p, double radius) const;
    /// share_within() of the polyline.
    double share(double radius, const Vec3& centre, const Vec3& edges, int samples) const;

    const std::vector<Vec3>& polyline() const { return polyline_; }

private:
    enum class Side { inside, outside, unknown };
    Side side(const Vec3& p, double radius, double reach) const;

    std::vector<Vec3> polyline_;
    Vec3 low_;
    std::array<int, 3> blocks_ { 0, 0, 0 };
    std::vector<double> distance_; ///< of the blocks' centres
};

/// Share (0 to 1) of a box, given by its centre and full edge lengths along the axes, that lies within
/// `radius` of the polyline; sampled at `samples`^3 points when the border may cross the box.
double share_within(std::span<const Vec3> polyline, double radius, const Vec3& centre, const Vec3& edges, int samples);

} // namespace retractor
