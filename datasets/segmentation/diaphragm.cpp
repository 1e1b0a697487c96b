#include "datasets/segmentation/diaphragm.h"

#include <algorithm>
#include <cmath>

namespace retractor::segmentation {

namespace {

    constexpr int kNoLung = -1;

    /// The lowest plane with lung, per column.
    std::vector<int> lowest(const Extent& extent, const Mask& lung)
    {
        const auto columns = static_cast<std::size_t>(extent.size[0]) * static_cast<std::size_t>(extent.size[1]);
        std::vector<int> low(columns, kNoLung);
        for (int k = extent.size[2] - 1; k >= 0; --k)
            for (std::size_t c = 0; c < columns; ++c)
                if (lung[static_cast<std::size_t>(k) * columns + c] != 0)
                    low[c] = k;
        return low;
    }

    template <typename Visit> void for_neighbours(const Extent& extent, std::size_t column, const Visit& visit)
    {
        const int nx = extent.size[0];
        const int i = static_cast<int>(column) % nx;
        const int j = static_cast<int>(column) / nx;
        if (i > 0)
            visit(column - 1);
        if (i + 1 < nx)
            visit(column + 1);
        if (j > 0)
            visit(column - static_cast<std::size_t>(nx));
        if (j + 1 < extent.size[1])
            visit(column + static_cast<std::size_t>(nx));
    }

    /// Follows the lower face of a lung from its lowest point as far as it is continuous: from the recess up over the
    /// dome, until it jumps to the side of the heart.
    void follow(const Extent& extent, const std::vector<int>& low, std::vector<std::uint8_t>& known)
    {
        constexpr double kJump = 12.0; // mm from one column to the next
        const int jump = static_cast<int>(kJump / extent.spacing[2]);
        std::size_t start = low.size();
        for (std::size_t c = 0; c < low.size(); ++c)
            if (low[c] != kNoLung && (start == low.size() || low[c] < low[start]))
                start = c;
        if (start == low.size())
            return;
        std::vector<std::size_t> front { start };
        known[start] = 1;
        for (std::size_t n = 0; n < front.size(); ++n)
            for_neighbours(extent, front[n], [&](std::size_t next) {
                if (known[next] == 0 && low[next] != kNoLung && std::abs(low[next] - low[front[n]]) <= jump) {
                    known[next] = 1;
                    front.push_back(next);
                }
            });
    }

    /// The height of a dome: what most columns of the zone stay below; NaN for an empty zone.
    double dome_top(std::vector<int> heights)
    {
        constexpr double kShare = 0.98;
        if (heights.empty())
            return std::nan("");
        const auto at = heights.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(heights.size() - 1));
        std::nth_element(heights.begin(), at, heights.end());
        return *at;
    }

    /// Where the lung's lower face climbs higher than its dome does away from the heart, it lies on the heart. The
    /// right dome is looked at away from the midline, the left one behind the heart.
    void drop_heart(const Extent& extent, const std::array<std::vector<int>, 2>& low,
        std::array<std::vector<std::uint8_t>, 2>& followed)
    {
        constexpr double kAway = 0.4; // of the distance from the midline to the lung's outer face
        constexpr double kAbove = 4.0; // mm
        constexpr double kLeftAbove = 10.0;
        constexpr double kBesideHeart = 0.36; // nearer to the midline, in front, the lung lies on the heart's sides
        double left_x = 0.0;
        double right_x = extent.size[0];
        double low_y = extent.size[1];
        double high_y = 0.0;
        for (std::size_t c = 0; c < low[0].size(); ++c)
            if (followed[0][c] != 0 || followed[1][c] != 0) {
                const double x = static_cast<double>(c % static_cast<std::size_t>(extent.size[0]));
                const double y = static_cast<double>(c / static_cast<std::size_t>(extent.size[0]));
                left_x = std::max(left_x, x);
                right_x = std::min(right_x, x);
                low_y = std::min(low_y, y);
                high_y = std::max(high_y, y);
            }
        const double middle = 0.5 * (left_x + right_x);
        const double half = 0.5 * (left_x - right_x);
        std::array<std::vector<int>, 2> zone;
        for (std::size_t side = 0; side < 2; ++side)
            for (std::size_t c = 0; c < low[side].size(); ++c) {
                const double x = static_cast<double>(c % static_cast<std::size_t>(extent.size[0])) - middle;
                const double y = static_cast<double>(c / static_cast<std::size_t>(extent.size[0]));
                if (followed[side][c] != 0 && std::abs(x) > kAway * half && (side == 1 || 2.0 * y > low_y + high_y))
                    zone[side].push_back(low[side][c]);
            }
        const double right = dome_top(zone[1]) + kAbove / extent.spacing[2];
        const double left = dome_top(zone[0]) + kLeftAbove / extent.spacing[2];
        const std::array<double, 2> most { std::fmin(left, right), std::isnan(right) ? left : right };
        for (std::size_t side = 0; side < 2; ++side)
            for (std::size_t c = 0; c < low[side].size(); ++c) {
                const double x = static_cast<double>(c % static_cast<std::size_t>(extent.size[0])) - middle;
                const double y = static_cast<double>(c / static_cast<std::size_t>(extent.size[0]));
                const bool beside_heart = std::abs(x) < kBesideHeart * half && 2.0 * y < low_y + high_y;
                if (low[side][c] > most[side] || beside_heart)
                    followed[side][c] = 0;
            }
    }

    /// A membrane through the known columns over the domain; free at its rim.
    void complete_columns(const Extent& extent, const std::vector<std::uint8_t>& domain,
        const std::vector<std::uint8_t>& known, std::vector<double>& height)
    {
        constexpr int kSweeps = 500;
        constexpr double kOverRelaxation = 1.93;
        constexpr double kDone = 0.005; // planes per sweep
        for (int sweep = 0; sweep < kSweeps; ++sweep) {
            double largest = 0.0;
            for (std::size_t c = 0; c < height.size(); ++c) {
                if (domain[c] == 0 || known[c] != 0)
                    continue;
                double sum = 0.0;
                int count = 0;
                for_neighbours(extent, c, [&](std::size_t next) {
                    if (domain[next] != 0) {
                        sum += height[next];
                        ++count;
                    }
                });
                if (count == 0)
                    continue;
                const double change = kOverRelaxation * (sum / count - height[c]);
                height[c] += change;
                largest = std::max(largest, std::abs(change));
            }
            if (largest < kDone)
                return;
        }
    }

} // namespace

DiaphragmHeight diaphragm_height(const Extent& extent, const Mask& inside, const Lungs& lungs)
{
    constexpr double kAgrees = 12.0; // mm between a lung's lower face and the membrane through the rest
    const std::array<std::vector<int>, 2> low { lowest(extent, lungs.left), lowest(extent, lungs.right) };
    const std::size_t columns = low[0].size();
    std::vector<std::uint8_t> domain(columns, 0);
    for (std::size_t v = 0; v < inside.size(); ++v)
        if (inside[v] != 0)
            domain[v % columns] = 1;

    DiaphragmHeight out;
    std::vector<std::uint8_t> known(columns, 0);
    std::vector<int> seen(columns, kNoLung);
    std::array<std::vector<std::uint8_t>, 2> followed;
    for (std::size_t side = 0; side < 2; ++side) {
        followed[side].assign(columns, 0);
        follow(extent, low[side], followed[side]);
    }
    drop_heart(extent, low, followed);
    for (std::size_t side = 0; side < 2; ++side)
        for (std::size_t c = 0; c < columns; ++c) {
            if (low[side][c] != kNoLung && (seen[c] == kNoLung || low[side][c] < seen[c]))
                seen[c] = low[side][c];
            if (followed[side][c] != 0)
                known[c] = 1;
        }
    double mean = 0.0;
    double count = 0.0;
    out.plane.assign(columns, 0.0);
    for (std::size_t c = 0; c < columns; ++c)
        if (known[c] != 0) {
            domain[c] = 1;
            // A lung that leaves the image says only that the diaphragm lies below.
            out.plane[c] = seen[c] > 0 ? seen[c] - 0.5 : -2.0;
            out.seen = out.seen || seen[c] > 0;
            mean += out.plane[c];
            count += 1.0;
        }
    for (std::size_t c = 0; c < columns; ++c)
        if (known[c] == 0)
            out.plane[c] = count > 0.0 ? mean / count : -2.0;
    for (int pass = 0; pass < 2; ++pass) {
        complete_columns(extent, domain, known, out.plane);
        for (std::size_t c = 0; c < columns; ++c)
            if (known[c] == 0 && seen[c] != kNoLung && std::abs(seen[c] - out.plane[c]) * extent.spacing[2] < kAgrees) {
                known[c] = 1;
                out.plane[c] = seen[c] - 0.5;
            }
    }
    return out;
}

} // namespace retractor::segmentation
