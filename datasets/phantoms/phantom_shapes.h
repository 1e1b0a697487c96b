#pragma once
// Implicit shapes for the phantoms. A shape is a signed distance in mm, negative inside. The distances of ellipsoids
// are first-order approximations: the surface and the sign are exact, values far away are distorted.

#include "mesh/base/geometry.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace retractor::datasets {

/// The point of a curve nearest to a given point.
struct Nearest {
    Vec3 point = Vec3::Zero();
    double distance = 0.0; ///< distance of the two points, mm
};

/// The point of the segment from `a` to `b` nearest to `p`.
Nearest nearest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b);

/// A chain of capsules: a polyline with a radius that varies linearly along each segment.
struct Tube {
    std::vector<Vec3> points;
    std::vector<double> radii; ///< mm, one per point
    /// Corners of the bounding box, radii included.
    Vec3 low = Vec3::Zero();
    Vec3 high = Vec3::Zero();
};
/// Makes a tube and its bounding box. @pre There are as many radii as points.
Tube make_tube(std::vector<Vec3> points, std::vector<double> radii);

/// Beyond this distance (mm) from the tube's box, tube_distance() returns the distance to the box. This lower bound of
/// the distance costs almost nothing.
inline constexpr double kFarFromTube = 20.0;
/// Signed distance to a tube, mm.
double tube_distance(const Tube& tube, const Vec3& p);

/// Signed distance to an ellipsoid whose axes are the columns of `axes` (orthonormal), to first order.
double ellipsoid_distance(const Vec3& p, const Vec3& centre, const Mat3& axes, const Vec3& radii);

/// Union of two distances with a fillet of about `k` mm.
double smooth_min(double a, double b, double k);

/// 0 below `low`, 1 above `high`, smooth between.
double smooth_step(double low, double high, double x);

/// Signed distance to a triangle in the plane, for any order of its vertices.
double triangle_distance(const Eigen::Vector2d& p, const std::array<Eigen::Vector2d, 3>& triangle);

/// A curve through (x, y) knots with rising x: cubic Hermite with finite-difference slopes, constant outside the knots.
class Profile {
public:
    explicit Profile(std::vector<Eigen::Vector2d> knots);
    double operator()(double x) const;

private:
    std::vector<Eigen::Vector2d> knots_;
    std::vector<double> slopes_;
};

/// A smooth curve through `corners`. Each segment becomes `pieces` segments of a Catmull-Rom spline.
std::vector<Vec3> smooth_polyline(std::span<const Vec3> corners, int pieces);

/// A random number with mean 0 and standard deviation 1, the scaled sum of four uniform numbers. The number depends
/// only on seed and index, so that the noise does not depend on the order in which voxels are visited.
double gaussian_noise(std::uint64_t seed, std::uint64_t index);

} // namespace retractor::datasets
