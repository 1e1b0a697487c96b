#include "datasets/segmentation/diaphragm.h"

#include "mesh/base/statistics.h"

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <cmath>

namespace retractor::datasets::segmentation {

namespace {

    constexpr int kNoLung = -1;

    /// The lowest plane with lung in each column.
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

    /// Follows the lower face of a lung from its lowest point while the face is continuous: from the recess over the
    /// dome to the jump at the side of the heart.
    void follow(const Extent& extent, const std::vector<int>& low, std::vector<std::uint8_t>& known)
    {
        constexpr double kJump = 12.0; // mm between neighbouring columns
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

    /// The height of a dome, a high quantile of the zone's heights; NaN for an empty zone.
    double dome_top(std::vector<int> heights)
    {
        constexpr double kShare = 0.98;
        if (heights.empty())
            return std::nan("");
        return value_of_rank(heights, static_cast<std::size_t>(kShare * static_cast<double>(heights.size() - 1)));
    }

    /// Drops columns where the lung lies on the heart: there the lower face rises above the dome. The height of the
    /// right dome is measured away from the midline, the height of the left dome behind the heart.
    void drop_heart(const Extent& extent, const std::array<std::vector<int>, 2>& low,
        std::array<std::vector<std::uint8_t>, 2>& followed)
    {
        constexpr double kAway = 0.4; // share of the distance from the midline to the lung's outer face
        constexpr double kAbove = 4.0; // mm above the dome
        // In front, the lung nearer to the midline than this (share of the half-width) lies on the sides of the heart.
        constexpr std::array<double, 2> kBesideHeart { 0.65, 0.2 };
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
        const double left = dome_top(zone[0]) + kAbove / extent.spacing[2];
        const std::array<double, 2> most { std::fmin(left, right), std::isnan(right) ? left : right };
        for (std::size_t side = 0; side < 2; ++side)
            for (std::size_t c = 0; c < low[side].size(); ++c) {
                const double x = static_cast<double>(c % static_cast<std::size_t>(extent.size[0])) - middle;
                const double y = static_cast<double>(c / static_cast<std::size_t>(extent.size[0]));
                const bool beside_heart = std::abs(x) < kBesideHeart[side] * half && 2.0 * y < low_y + high_y;
                if (low[side][c] > most[side] || beside_heart)
                    followed[side][c] = 0;
            }
    }

    constexpr int kCells = 4; // columns along each side of a cell of the plate

    /// Interpolates unknown heights by a plate under tension through the known columns, on cells. The plate is smooth
    /// over the domes and stretched between them.
    void complete_columns(const Extent& extent, const std::vector<std::uint8_t>& known, std::vector<double>& height)
    {
        constexpr double kStiffness = 0.2; // relative to one known cell
        // A larger value flattens the domes, a smaller value overshoots under the heart.
        constexpr double kTension = 0.2;
        constexpr double kHold = 1e-6; // holds the plate where no column is known
        const int nx = (extent.size[0] + kCells - 1) / kCells;
        const int ny = (extent.size[1] + kCells - 1) / kCells;
        const auto cell_of = [&](std::size_t column) {
            const int i = static_cast<int>(column) % extent.size[0] / kCells;
            const int j = static_cast<int>(column) / extent.size[0] / kCells;
            return j * nx + i;
        };
        Eigen::VectorXd sum = Eigen::VectorXd::Zero(nx * ny);
        Eigen::VectorXd weight = Eigen::VectorXd::Zero(nx * ny);
        for (std::size_t c = 0; c < height.size(); ++c)
            if (known[c] != 0) {
                sum[cell_of(c)] += height[c];
                weight[cell_of(c)] += 1.0;
            }
        const double mean = sum.sum() / std::max(1.0, weight.sum());
        std::vector<Eigen::Triplet<double>> entries;
        Eigen::VectorXd right(nx * ny);
        for (int c = 0; c < nx * ny; ++c) {
            const double hold = weight[c] > 0.0 ? 1.0 : kHold;
            entries.emplace_back(c, c, hold);
            right[c] = hold * (weight[c] > 0.0 ? sum[c] / weight[c] : mean);
        }
        const auto bend = [&](std::initializer_list<std::pair<int, double>> row, double factor) {
            for (const auto& [a, wa] : row)
                for (const auto& [b, wb] : row)
                    entries.emplace_back(a, b, factor * kStiffness * wa * wb);
        };
        for (int j = 0; j < ny; ++j)
            for (int i = 0; i < nx; ++i) {
                const int c = j * nx + i;
                if (i + 1 < nx)
                    bend({ { c, -1.0 }, { c + 1, 1.0 } }, kTension / kStiffness);
                if (j + 1 < ny)
                    bend({ { c, -1.0 }, { c + nx, 1.0 } }, kTension / kStiffness);
                if (i > 0 && i + 1 < nx)
                    bend({ { c - 1, 1.0 }, { c, -2.0 }, { c + 1, 1.0 } }, 1.0);
                if (j > 0 && j + 1 < ny)
                    bend({ { c - nx, 1.0 }, { c, -2.0 }, { c + nx, 1.0 } }, 1.0);
                if (i + 1 < nx && j + 1 < ny)
                    bend({ { c, 1.0 }, { c + 1, -1.0 }, { c + nx, -1.0 }, { c + nx + 1, 1.0 } }, 2.0);
            }
        Eigen::SparseMatrix<double> plate(nx * ny, nx * ny);
        plate.setFromTriplets(entries.begin(), entries.end());
        const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(plate);
        const Eigen::VectorXd bent = solver.solve(right);
        for (std::size_t c = 0; c < height.size(); ++c) {
            if (known[c] != 0)
                continue;
            const double x = (static_cast<double>(static_cast<int>(c) % extent.size[0]) + 0.5) / kCells - 0.5;
            const double y = (static_cast<double>(static_cast<int>(c) / extent.size[0]) + 0.5) / kCells - 0.5;
            const int i = std::clamp(static_cast<int>(x), 0, std::max(0, nx - 2));
            const int j = std::clamp(static_cast<int>(y), 0, std::max(0, ny - 2));
            const double tx = std::clamp(x - i, 0.0, 1.0);
            const double ty = std::clamp(y - j, 0.0, 1.0);
            const auto at
                = [&](int di, int dj) { return bent[std::min(j + dj, ny - 1) * nx + std::min(i + di, nx - 1)]; };
            height[c]
                = (1.0 - ty) * ((1.0 - tx) * at(0, 0) + tx * at(1, 0)) + ty * ((1.0 - tx) * at(0, 1) + tx * at(1, 1));
        }
    }

} // namespace

DiaphragmHeight diaphragm_height(const Extent& extent, const Lungs& lungs)
{
    constexpr double kAgrees = 5.0; // mm between a lung's lower face and the plate through the other columns
    const std::array<std::vector<int>, 2> low { lowest(extent, lungs.left), lowest(extent, lungs.right) };
    const std::size_t columns = low[0].size();

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
    out.plane.assign(columns, -2.0);
    for (std::size_t c = 0; c < columns; ++c)
        if (known[c] != 0) {
            // A lung that leaves the image shows only that the diaphragm lies below the image.
            out.plane[c] = seen[c] > 0 ? seen[c] - 0.5 : -2.0;
            out.seen = out.seen || seen[c] > 0;
        }
    for (int pass = 0; pass < 2; ++pass) {
        complete_columns(extent, known, out.plane);
        for (std::size_t c = 0; c < columns; ++c)
            if (known[c] == 0 && seen[c] != kNoLung && std::abs(seen[c] - out.plane[c]) * extent.spacing[2] < kAgrees) {
                known[c] = 1;
                out.plane[c] = seen[c] - 0.5;
            }
    }
    return out;
}

} // namespace retractor::datasets::segmentation
