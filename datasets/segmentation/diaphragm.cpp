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
    for (const std::vector<int>& one : low) {
        std::vector<std::uint8_t> followed(columns, 0);
        follow(extent, one, followed);
        for (std::size_t c = 0; c < columns; ++c) {
            if (one[c] != kNoLung && (seen[c] == kNoLung || one[c] < seen[c]))
                seen[c] = one[c];
            if (followed[c] != 0)
                known[c] = 1;
        }
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
