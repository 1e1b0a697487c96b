#include "mesh/base/corridor.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace retractor {

namespace {

    double squared_segment_distance(std::span<const Vec3> polyline, std::size_t segment, const Vec3& p)
    {
        const Vec3 along = polyline[segment + 1] - polyline[segment];
        const double length2 = along.squaredNorm();
        const double t = length2 > 0.0 ? std::clamp((p - polyline[segment]).dot(along) / length2, 0.0, 1.0) : 0.0;
        return (p - polyline[segment] - t * along).squaredNorm();
    }

} // namespace

double polyline_distance(std::span<const Vec3> polyline, const Vec3& p)
{
    if (polyline.empty())
        return std::numeric_limits<double>::infinity();
    double nearest = (p - polyline.front()).squaredNorm();
    for (std::size_t i = 0; i + 1 < polyline.size(); ++i)
        nearest = std::min(nearest, squared_segment_distance(polyline, i, p));
    return std::sqrt(nearest);
}

double share_within(std::span<const Vec3> polyline, double radius, const Vec3& centre, const Vec3& edges, int samples)
{
    RETRACTOR_ASSERT(samples > 0);
    const double distance = polyline_distance(polyline, centre);
    const double reach = 0.5 * edges.norm();
    if (distance + reach <= radius)
        return 1.0;
    if (distance - reach > radius)
        return 0.0;
    int inside = 0;
    for (int k = 0; k < samples; ++k)
        for (int j = 0; j < samples; ++j)
            for (int i = 0; i < samples; ++i) {
                const Vec3 unit = (Vec3(i, j, k).array() + 0.5) / samples - 0.5;
                inside += polyline_distance(polyline, centre + edges.cwiseProduct(unit)) <= radius;
            }
    return static_cast<double>(inside) / (samples * samples * samples);
}

namespace {
    constexpr double kBlockMm = 8.0;
    /// Half the diagonal of a block, plus a margin above round-off.
    const double kBlockReachMm = 0.5 * std::sqrt(3.0) * kBlockMm + 1e-6;
} // namespace

CorridorDistance::CorridorDistance(std::vector<Vec3> polyline, const Vec3& low, const Vec3& high)
    : polyline_(std::move(polyline))
    , low_(low)
{
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<Eigen::Index>(axis);
        blocks_[axis] = std::max(1, static_cast<int>(std::ceil((high[a] - low[a]) / kBlockMm)));
    }
    for (int k = 0; k < blocks_[2]; ++k)
        for (int j = 0; j < blocks_[1]; ++j)
            for (int i = 0; i < blocks_[0]; ++i)
                add_block(low_ + kBlockMm * (Vec3(i, j, k) + Vec3::Constant(0.5)));
}

void CorridorDistance::add_block(const Vec3& centre)
{
    distance_.push_back(polyline_distance(polyline_, centre));
    const double farthest = distance_.back() + 2.0 * kBlockReachMm;
    for (std::size_t segment = 0; segment + 1 < polyline_.size(); ++segment)
        if (squared_segment_distance(polyline_, segment, centre) <= farthest * farthest)
            segments_.push_back(static_cast<std::int32_t>(segment));
    first_segment_.push_back(static_cast<std::int32_t>(segments_.size()));
}

std::optional<std::size_t> CorridorDistance::block_of(const Vec3& p) const
{
    std::size_t block = 0;
    for (int axis = 2; axis >= 0; --axis) {
        const double at = (p[axis] - low_[axis]) / kBlockMm;
        const int count = blocks_[static_cast<std::size_t>(axis)];
        if (!(at >= 0.0) || !(at < count))
            return std::nullopt;
        block = block * static_cast<std::size_t>(count) + static_cast<std::size_t>(at);
    }
    RETRACTOR_ASSERT(block < distance_.size());
    return block;
}

CorridorDistance::Side CorridorDistance::side(const Vec3& p, double radius, double reach) const
{
    const std::optional<std::size_t> block = block_of(p);
    if (!block)
        return Side::unknown;
    reach += kBlockReachMm;
    return distance_[*block] + reach <= radius ? Side::inside
        : distance_[*block] - reach > radius   ? Side::outside
                                               : Side::unknown;
}

double CorridorDistance::distance(const Vec3& p) const
{
    const std::optional<std::size_t> block = block_of(p);
    if (!block || polyline_.empty())
        return polyline_distance(polyline_, p);
    double nearest = (p - polyline_.front()).squaredNorm();
    for (auto i = first_segment_[*block]; i < first_segment_[*block + 1]; ++i)
        nearest = std::min(nearest,
            squared_segment_distance(polyline_, static_cast<std::size_t>(segments_[static_cast<std::size_t>(i)]), p));
    return std::sqrt(nearest);
}

bool CorridorDistance::within(const Vec3& p, double radius) const
{
    const Side place = side(p, radius, 0.0);
    return place == Side::unknown ? distance(p) <= radius : place == Side::inside;
}

double CorridorDistance::share(double radius, const Vec3& centre, const Vec3& edges, int samples) const
{
    const Side place = side(centre, radius, 0.5 * edges.norm());
    return place == Side::unknown ? share_within(polyline_, radius, centre, edges, samples)
                                  : (place == Side::inside ? 1.0 : 0.0);
}

} // namespace retractor
