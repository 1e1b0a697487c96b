#include "mesh/surface/proximity.h"

#include "mesh/base/error.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>

namespace retractor::mesh {

namespace {

    constexpr int kBits = 20; // bits of a cell's number along an axis

    std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z)
    {
        const auto bits = [](std::int64_t i) { return static_cast<std::uint64_t>(i); };
        return bits(z) << (2 * kBits) | bits(y) << kBits | bits(x);
    }

    ClosestPoint on_segment(const Vec3& p, const Vec3& a, const Vec3& b, int at_a, int at_b)
    {
        const Vec3 ab = b - a;
        const double squared = ab.squaredNorm();
        const double t = squared > 0.0 ? std::clamp((p - a).dot(ab) / squared, 0.0, 1.0) : 0.0;
        ClosestPoint closest { Vec3::Zero(), (p - a - t * ab).norm() };
        closest.barycentric[at_a] = 1.0 - t;
        closest.barycentric[at_b] = t;
        return closest;
    }

} // namespace

ClosestPoint closest_on_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) noexcept
{
    const Vec3 n = (b - a).cross(c - a);
    const double squared = n.squaredNorm();
    if (squared > 0.0) {
        const Vec3 w = p - a;
        const double v = w.cross(c - a).dot(n) / squared, u = (b - a).cross(w).dot(n) / squared;
        if (v >= 0.0 && u >= 0.0 && v + u <= 1.0)
            return { Vec3(1.0 - v - u, v, u), std::abs(w.dot(n)) / std::sqrt(squared) };
    }
    ClosestPoint best = on_segment(p, a, b, 0, 1);
    for (const ClosestPoint& other : { on_segment(p, b, c, 1, 2), on_segment(p, c, a, 2, 0) })
        if (other.distance < best.distance)
            best = other;
    return best;
}

TriangleProximity::TriangleProximity(Points vertices, std::vector<std::array<VertexId, 3>> triangles, double reach)
    : vertices_(std::move(vertices))
    , triangles_(std::move(triangles))
    , reach_(reach)
{
    if (!(reach > 0.0 && std::isfinite(reach)))
        throw InputError("the reach must be positive", "proximity");
    if (triangles_.empty())
        return;
    Eigen::AlignedBox3d whole;
    double extent = 0.0;
    const auto box = [&](std::size_t t) {
        Eigen::AlignedBox3d round;
        for (const VertexId v : triangles_[t])
            round.extend(point_at(vertices_, v));
        return round;
    };
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        for (const VertexId v : triangles_[t])
            if (v < 0 || v >= vertices_.rows() || !vertices_.row(v).allFinite())
                throw InputError("vertex " + std::to_string(v) + " is out of range or not finite",
                    "proximity, triangle " + std::to_string(t));
        whole.extend(box(t));
        extent += box(t).sizes().maxCoeff() / static_cast<double>(triangles_.size());
    }
    // With cells as large as the reach, a search visits 27 cells. Cells smaller than the triangles would only be more
    // cells.
    centroids_.reserve(triangles_.size());
    radii_.reserve(triangles_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const auto [a, b, c] = triangle_corners(vertices_, triangles_[t]);
        centroids_.push_back((a + b + c) / 3.0);
        double radius = 0.0;
        for (const Vec3& corner : { a, b, c })
            radius = std::max(radius, (corner - centroids_[t]).norm());
        radii_.push_back(radius);
    }
    size_ = std::max({ reach, extent, whole.sizes().maxCoeff() / ((1 << kBits) - 4) });
    origin_ = whole.min() - Vec3::Constant(size_);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const auto first = cell(box(t).min()), last = cell(box(t).max());
        for (std::int64_t z = first[2]; z <= last[2]; ++z)
            for (std::int64_t y = first[1]; y <= last[1]; ++y)
                for (std::int64_t x = first[0]; x <= last[0]; ++x)
                    cells_.emplace_back(key(x, y, z), static_cast<std::int32_t>(t));
    }
    std::sort(cells_.begin(), cells_.end());
}

std::array<std::int64_t, 3> TriangleProximity::cell(const Vec3& point) const
{
    std::array<std::int64_t, 3> place {};
    for (Eigen::Index axis = 0; axis < 3; ++axis) // points far away fall into cells without triangles
        place[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(
            std::clamp(std::floor((point[axis] - origin_[axis]) / size_), 0.0, static_cast<double>((1 << kBits) - 1)));
    return place;
}

std::vector<TriangleProximity::Nearby> TriangleProximity::within(const Vec3& point, double distance) const
{
    std::vector<Nearby> nearby;
    if (cells_.empty() || !point.allFinite())
        return nearby;
    distance = std::min(distance, reach_);
    const auto first = cell(point - Vec3::Constant(distance)), last = cell(point + Vec3::Constant(distance));
    constexpr double kAboveRoundOff = 1.0 + 1e-9;
    std::vector<std::int32_t> met;
    for (std::int64_t z = first[2]; z <= last[2]; ++z)
        for (std::int64_t y = first[1]; y <= last[1]; ++y) {
            // The cells of a row are successive in the list.
            const auto from = std::lower_bound(cells_.begin(), cells_.end(), std::pair(key(first[0], y, z), 0));
            for (auto at = from; at != cells_.end() && at->first <= key(last[0], y, z); ++at) {
                const auto t = static_cast<std::size_t>(at->second);
                const double reach = (distance + radii_[t]) * kAboveRoundOff;
                if ((point - centroids_[t]).squaredNorm() <= reach * reach)
                    met.push_back(at->second);
            }
        }
    std::sort(met.begin(), met.end());
    met.erase(std::unique(met.begin(), met.end()), met.end());
    for (const std::int32_t t : met) {
        const auto& corners = triangles_[static_cast<std::size_t>(t)];
        const auto [a, b, c] = triangle_corners(vertices_, corners);
        const ClosestPoint closest = closest_on_triangle(point, a, b, c);
        if (closest.distance <= distance)
            nearby.push_back({ t, closest });
    }
    std::stable_sort(nearby.begin(), nearby.end(),
        [](const Nearby& a, const Nearby& b) { return a.point.distance < b.point.distance; });
    return nearby;
}

} // namespace retractor::mesh
