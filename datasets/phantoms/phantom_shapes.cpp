#include "datasets/phantoms/phantom_shapes.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace retractor::datasets {

Nearest nearest_on_segment(const Vec3& p, const Vec3& a, const Vec3& b)
{
    const Vec3 ab = b - a;
    const double length2 = ab.squaredNorm();
    const double t = length2 > 0.0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
    const Vec3 point = a + t * ab;
    return { point, (p - point).norm() };
}

Tube make_tube(std::vector<Vec3> points, std::vector<double> radii)
{
    RETRACTOR_ASSERT(points.size() == radii.size());
    Tube tube { std::move(points), std::move(radii), Vec3::Constant(std::numeric_limits<double>::infinity()),
        Vec3::Constant(-std::numeric_limits<double>::infinity()) };
    for (std::size_t i = 0; i < tube.points.size(); ++i) {
        tube.low = tube.low.cwiseMin(Vec3(tube.points[i].array() - tube.radii[i]));
        tube.high = tube.high.cwiseMax(Vec3(tube.points[i].array() + tube.radii[i]));
    }
    return tube;
}

double tube_distance(const Tube& tube, const Vec3& p)
{
    const double outside = (tube.low - p).cwiseMax(p - tube.high).cwiseMax(0.0).norm();
    if (outside > kFarFromTube)
        return outside;
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i + 1 < tube.points.size(); ++i) {
        const Vec3& a = tube.points[i];
        const Vec3 ab = tube.points[i + 1] - a;
        const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
        const double radius = tube.radii[i] + t * (tube.radii[i + 1] - tube.radii[i]);
        best = std::min(best, (p - a - t * ab).norm() - radius);
    }
    return best;
}

double ellipsoid_distance(const Vec3& p, const Vec3& centre, const Mat3& axes, const Vec3& radii)
{
    const Vec3 q = axes.transpose() * (p - centre);
    const double k0 = q.cwiseQuotient(radii).norm();
    const double k1 = q.cwiseQuotient(radii.cwiseProduct(radii)).norm();
    return k1 > 0.0 ? k0 * (k0 - 1.0) / k1 : -radii.minCoeff();
}

double smooth_min(double a, double b, double k)
{
    const double h = std::max(k - std::abs(a - b), 0.0) / k;
    return std::min(a, b) - h * h * k * 0.25;
}

double smooth_step(double low, double high, double x)
{
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

double triangle_distance(const Eigen::Vector2d& p, const std::array<Eigen::Vector2d, 3>& triangle)
{
    double best = std::numeric_limits<double>::infinity();
    int positive = 0;
    for (std::size_t e = 0; e < 3; ++e) {
        const Eigen::Vector2d& a = triangle[e];
        const Eigen::Vector2d ab = triangle[(e + 1) % 3] - a;
        const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
        best = std::min(best, (p - a - t * ab).norm());
        if (ab.x() * (p.y() - a.y()) - ab.y() * (p.x() - a.x()) > 0.0)
            ++positive;
    }
    return positive == 0 || positive == 3 ? -best : best;
}

Profile::Profile(std::vector<Eigen::Vector2d> knots)
    : knots_(std::move(knots))
    , slopes_(knots_.size(), 0.0)
{
    for (std::size_t i = 1; i + 1 < knots_.size(); ++i)
        slopes_[i] = (knots_[i + 1].y() - knots_[i - 1].y()) / (knots_[i + 1].x() - knots_[i - 1].x());
}

double Profile::operator()(double x) const
{
    if (x <= knots_.front().x())
        return knots_.front().y();
    if (x >= knots_.back().x())
        return knots_.back().y();
    std::size_t i = 0;
    while (knots_[i + 1].x() < x)
        ++i;
    const double h = knots_[i + 1].x() - knots_[i].x();
    const double t = (x - knots_[i].x()) / h;
    const double t2 = t * t;
    const double t3 = t2 * t;
    return (2.0 * t3 - 3.0 * t2 + 1.0) * knots_[i].y() + (t3 - 2.0 * t2 + t) * h * slopes_[i]
        + (3.0 * t2 - 2.0 * t3) * knots_[i + 1].y() + (t3 - t2) * h * slopes_[i + 1];
}

std::vector<Vec3> smooth_polyline(std::span<const Vec3> corners, int pieces)
{
    std::vector<Vec3> points;
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
        const Vec3& p1 = corners[i];
        const Vec3& p2 = corners[i + 1];
        const Vec3 p0 = i > 0 ? corners[i - 1] : Vec3(2.0 * p1 - p2);
        const Vec3 p3 = i + 2 < corners.size() ? corners[i + 2] : Vec3(2.0 * p2 - p1);
        for (int s = 0; s < pieces; ++s) {
            const double t = static_cast<double>(s) / pieces;
            points.emplace_back(0.5
                * (2.0 * p1 + t * (p2 - p0) + t * t * (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3)
                    + t * t * t * (3.0 * p1 - 3.0 * p2 + p3 - p0)));
        }
    }
    points.push_back(corners.back());
    return points;
}

double gaussian_noise(std::uint64_t seed, std::uint64_t index)
{
    // splitmix64 serves as a hash of (seed, index).
    std::uint64_t z = (seed + 1) * 0x9e3779b97f4a7c15ULL + index * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    z ^= z >> 31U;
    double sum = 0.0;
    for (unsigned part = 0; part < 4; ++part)
        sum += static_cast<double>((z >> (16U * part)) & 0xffffU) / 65535.0 - 0.5;
    return sum * std::sqrt(3.0); // the sum of four uniform numbers has variance 4/12
}

} // namespace retractor::datasets
