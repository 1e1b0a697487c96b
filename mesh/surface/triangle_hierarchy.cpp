#include "mesh/surface/triangle_hierarchy.h"

#include "mesh/base/assert.h"
#include "mesh/base/triangle.h"
#include "mesh/surface/proximity.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace retractor::mesh {

namespace {

    constexpr std::int32_t kLeafTriangles = 4;
    constexpr double kAboveRoundOff = 1.0 + 1e-9; // of a distance against that of its box
    constexpr double kRoundOff = 1e-12; // of a scalar product against that of its box

    /// Squared distance of a point from a box, mm^2.
    double squared_distance(const Vec3& point, const Vec3& low, const Vec3& high)
    {
        return (low - point).cwiseMax(point - high).cwiseMax(0.0).squaredNorm();
    }

    /// Least scalar product of a vector with the vectors in a box.
    double least_product(const Vec3& vector, const Vec3& low, const Vec3& high)
    {
        return vector.cwiseProduct(low).cwiseMin(vector.cwiseProduct(high)).sum();
    }

} // namespace

TriangleHierarchy::TriangleHierarchy(const Points& vertices, const std::vector<std::array<VertexId, 3>>& triangles)
    : order_(triangles.size())
    , corners_(triangles.size())
    , normals_(triangles.size())
{
    if (triangles.empty())
        return;
    std::vector<Vec3> middles;
    middles.reserve(triangles.size());
    for (const auto& triangle : triangles) {
        const auto [a, b, c] = triangle_corners(vertices, triangle);
        middles.push_back((a + b + c) / 3.0);
    }
    std::iota(order_.begin(), order_.end(), 0);
    nodes_.push_back({ 0, static_cast<std::int32_t>(triangles.size()) });
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
        const auto [begin, end, none] = nodes_[n];
        if (end - begin <= kLeafTriangles)
            continue;
        Eigen::AlignedBox3d box;
        for (std::int32_t i = begin; i < end; ++i)
            box.extend(middles[static_cast<std::size_t>(order_[static_cast<std::size_t>(i)])]);
        Eigen::Index longest = 0;
        box.sizes().maxCoeff(&longest);
        const std::int32_t half = begin + (end - begin) / 2;
        std::nth_element(
            order_.begin() + begin, order_.begin() + half, order_.begin() + end, [&](std::int32_t a, std::int32_t b) {
                return std::pair(middles[static_cast<std::size_t>(a)][longest], a)
                    < std::pair(middles[static_cast<std::size_t>(b)][longest], b);
            });
        nodes_[n].children = static_cast<std::int32_t>(nodes_.size());
        nodes_.push_back({ begin, half });
        nodes_.push_back({ half, end });
    }
    triangles_.reserve(triangles.size());
    for (const std::int32_t t : order_)
        triangles_.push_back(triangles[static_cast<std::size_t>(t)]);
    bounds_.resize(nodes_.size());
    refit(vertices);
}

void TriangleHierarchy::refit(const Points& vertices)
{
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
        corners_[i] = triangle_corners(vertices, triangles_[i]);
        normals_[i] = unit_normal(corners_[i]);
    }
    for (std::size_t n = nodes_.size(); n-- > 0;)
        fit(n);
}

void TriangleHierarchy::fit(std::size_t node)
{
    const Node& n = nodes_[node];
    Bounds& bounds = bounds_[node];
    if (n.children >= 0) {
        const Bounds &a = bounds_[static_cast<std::size_t>(n.children)],
                     &b = bounds_[static_cast<std::size_t>(n.children) + 1];
        bounds = { a.low.cwiseMin(b.low), a.high.cwiseMax(b.high), a.normal_low.cwiseMin(b.normal_low),
            a.normal_high.cwiseMax(b.normal_high) };
        return;
    }
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    bounds = { Vec3::Constant(kInfinity), Vec3::Constant(-kInfinity), Vec3::Constant(kInfinity),
        Vec3::Constant(-kInfinity) };
    for (auto i = static_cast<std::size_t>(n.begin); i < static_cast<std::size_t>(n.end); ++i) {
        for (const Vec3& corner : corners_[i]) {
            bounds.low = bounds.low.cwiseMin(corner);
            bounds.high = bounds.high.cwiseMax(corner);
        }
        bounds.normal_low = bounds.normal_low.cwiseMin(normals_[i]);
        bounds.normal_high = bounds.normal_high.cwiseMax(normals_[i]);
    }
}

std::optional<TriangleHierarchy::Found> TriangleHierarchy::nearest(
    const Query& query, const std::function<bool(std::int32_t)>& accept) const
{
    RETRACTOR_ASSERT(query.point.allFinite() && query.direction.allFinite());
    std::optional<Found> best;
    double limit = query.distance;
    const auto squared_distance_of = [&](std::int32_t node) {
        const Bounds& b = bounds_[static_cast<std::size_t>(node)];
        return squared_distance(query.point, b.low, b.high);
    };
    struct Open {
        std::int32_t node;
        double squared_distance;
    };
    std::array<Open, 64> stack; // a median split halves the triangles: no path has more nodes
    std::size_t open = 0;
    if (!nodes_.empty())
        stack[open++] = { 0, squared_distance_of(0) };
    while (open > 0) {
        const Open at = stack[--open];
        const Bounds& bounds = bounds_[static_cast<std::size_t>(at.node)];
        if (at.squared_distance > limit * limit * kAboveRoundOff
            || least_product(query.direction, bounds.normal_low, bounds.normal_high) >= query.cosine + kRoundOff)
            continue;
        const Node& node = nodes_[static_cast<std::size_t>(at.node)];
        if (node.children >= 0) {
            const Open first { node.children, squared_distance_of(node.children) },
                second { node.children + 1, squared_distance_of(node.children + 1) };
            const bool nearer = first.squared_distance <= second.squared_distance;
            stack[open++] = nearer ? second : first;
            stack[open++] = nearer ? first : second;
            continue;
        }
        for (auto i = static_cast<std::size_t>(node.begin); i < static_cast<std::size_t>(node.end); ++i) {
            if (!(query.direction.dot(normals_[i]) < query.cosine))
                continue;
            const auto& [a, b, c] = corners_[i];
            const double distance = closest_on_triangle(query.point, a, b, c).distance;
            if (!(best ? std::pair(distance, order_[i]) < std::pair(best->distance, best->triangle) : distance <= limit)
                || !accept(order_[i]))
                continue;
            best = Found { order_[i], distance };
            limit = distance;
        }
    }
    return best;
}

} // namespace retractor::mesh
