#pragma once
// Implicit shapes that the phantoms are made of. Distances in mm, negative inside. Distances of ellipsoids are
// first-order: right at the surface and in sign, stretched far away.

#include "mesh/base/geometry.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace retractor::datasets {

/// Where a point is nearest to a polyline, and how far.
struct Nearest {
    Vec3 point = Vec3::Zero();
    double distance = 0.0;
};

Nearest nearest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b);

/// A chain of capsules: a polyline grown by a radius that varies linearly along each piece.
struct Tube {
    std::vector<Vec3> points;
    std::vector<double> radii; ///< one per point
    Vec3 low = Vec3::Zero(); ///< box round it, radii included
    Vec3 high = Vec3::Zero();
};
Tube make_tube(std::vector<Vec3> points, std::vector<double> radii);

/// Signed distance; a point further than `kFarFromTube` from the tube's box gets the distance to the box, a lower
/// bound that costs nothing.
inline constexpr double kFarFromTube = 20.0;
double tube_distance(const Tube& tube, const Vec3& p);

/// Distance to an ellipsoid whose axes are the columns of `axes` (orthonormal).
double ellipsoid_distance(const Vec3& p, const Vec3& centre, const Mat3& axes, const Vec3& radii);

/// Union of two distances with a fillet of about `k` mm.
double smooth_min(double a, double b, double k);

/// 0 below `low`, 1 above `high`, smooth between.
double smooth_step(double low, double high, double x);

/// Signed distance to a triangle in the plane; the vertices in any order.
double triangle_distance(const Eigen::Vector2d& p, const std::array<Eigen::Vector2d, 3>& triangle);

/// A curve through (x, y) knots, x rising: cubic Hermite with finite-difference slopes, constant outside.
class Profile {
public:
    explicit Profile(std::vector<Eigen::Vector2d> knots);
    double operator()(double x) const;

private:
    std::vector<Eigen::Vector2d> knots_;
    std::vector<double> slopes_;
};

/// A smooth curve through `corners`: each piece is divided into `pieces` parts of a Catmull-Rom spline.
std::vector<Vec3> smooth_polyline(std::span<const Vec3> corners, int pieces);

/// A random unit with mean 0 and standard deviation 1, a function of seed and index only (no state, so that the
/// result does not depend on the order in which voxels are visited). Sum of four uniform numbers.
double gaussian_noise(std::uint64_t seed, std::uint64_t index);

} // namespace retractor::datasets
