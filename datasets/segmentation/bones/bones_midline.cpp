// Finds spine and sternum as paths through the slices. Each point of a slice has a score: its likeness to the bone,
// from boxes that should be bone and boxes that should not. Dynamic programming finds the best continuous path.

#include "datasets/segmentation/bones/bones_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace retractor::datasets::segmentation {

namespace {

    /// The bone content of each place (0 to 1), averaged over some height, with sums for boxes in each slice.
    class BoneMap {
    public:
        BoneMap(const CoarseImage& image, double half_height_mm)
            : grid_(image.grid)
        {
            constexpr double kSoft = 120.0, kBone = 300.0; // HU; spongy bone lies between the two
            const auto nx = static_cast<std::size_t>(grid_.size[0]), ny = static_cast<std::size_t>(grid_.size[1]);
            const std::size_t slice = nx * ny;
            std::vector<float> bone(image.hu.size());
            for (std::size_t v = 0; v < bone.size(); ++v)
                bone[v] = image.body[v]
                    ? static_cast<float>(std::clamp((image.hu[v] - kSoft) / (kBone - kSoft), 0.0, 1.0))
                    : 0.0F;
            const int half = std::max(0, static_cast<int>(std::lround(half_height_mm / grid_.spacing.z())));
            sums_.assign((nx + 1) * (ny + 1) * static_cast<std::size_t>(grid_.size[2]), 0.0);
            std::vector<double> mean(slice);
            for (int k = 0; k < grid_.size[2]; ++k) {
                std::fill(mean.begin(), mean.end(), 0.0);
                const int low = std::max(0, k - half), high = std::min(grid_.size[2] - 1, k + half);
                for (int c = low; c <= high; ++c)
                    for (std::size_t n = 0; n < slice; ++n)
                        mean[n] += bone[static_cast<std::size_t>(c) * slice + n];
                double* sums = sums_.data() + static_cast<std::size_t>(k) * (nx + 1) * (ny + 1);
                for (std::size_t j = 0; j < ny; ++j)
                    for (std::size_t i = 0; i < nx; ++i)
                        sums[(j + 1) * (nx + 1) + i + 1] = mean[j * nx + i] / (high - low + 1)
                            + sums[j * (nx + 1) + i + 1] + sums[(j + 1) * (nx + 1) + i] - sums[j * (nx + 1) + i];
            }
        }

        /// Mean over a box around voxel (i, j), with offsets in mm.
        double box(int i, int j, int k, double x0, double x1, double y0, double y1) const
        {
            const auto index = [](double mm, double h) { return static_cast<int>(std::lround(mm / h)); };
            const int a = std::clamp(i + index(x0, grid_.spacing.x()), 0, grid_.size[0] - 1);
            const int b = std::clamp(i + index(x1, grid_.spacing.x()), 0, grid_.size[0] - 1);
            const int c = std::clamp(j + index(y0, grid_.spacing.y()), 0, grid_.size[1] - 1);
            const int d = std::clamp(j + index(y1, grid_.spacing.y()), 0, grid_.size[1] - 1);
            const std::size_t row = static_cast<std::size_t>(grid_.size[0]) + 1;
            const double* sums
                = sums_.data() + static_cast<std::size_t>(k) * row * (static_cast<std::size_t>(grid_.size[1]) + 1);
            const auto at
                = [&](int x, int y) { return sums[static_cast<std::size_t>(y) * row + static_cast<std::size_t>(x)]; };
            return (at(b + 1, d + 1) - at(a, d + 1) - at(b + 1, c) + at(a, c)) / ((b - a + 1) * (d - c + 1));
        }

    private:
        mesh::ImageGrid grid_;
        std::vector<double> sums_;
    };

    constexpr double kImpossible = -1e6;

    /// Finds the path of best total score, with a shift of at most one voxel per slice. In a slice without a place that
    /// can be reached (empty slices at the ends of an image, or corners of an oblique one) the path stays where it is.
    /// `score(i, j, k)` gives the score.
    template <typename Score>
    std::vector<std::array<int, 2>> best_path(const mesh::ImageGrid& grid, double shift_cost, const Score& score)
    {
        const int nx = grid.size[0], ny = grid.size[1], nz = grid.size[2];
        const auto slice = static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny);
        std::vector<float> best(slice, 0.0F), next(slice);
        constexpr double kUnreached = -1e30;
        constexpr std::int8_t kStays = 4;
        std::vector<std::int8_t> from(slice * static_cast<std::size_t>(nz), kStays);
        bool has_begun = false;
        for (int k = 0; k < nz; ++k) {
            bool is_reached = false;
            for (int j = 0; j < ny; ++j)
                for (int i = 0; i < nx; ++i) {
                    const std::size_t n
                        = static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(i);
                    const double here = score(i, j, k);
                    double most = has_begun ? kUnreached : 0.0;
                    if (has_begun && here > kImpossible)
                        for (int dj = -1; dj <= 1; ++dj)
                            for (int di = -1; di <= 1; ++di) {
                                if (i + di < 0 || i + di >= nx || j + dj < 0 || j + dj >= ny)
                                    continue;
                                const double before = best[n + static_cast<std::size_t>(dj * nx + di)]
                                    - shift_cost * (std::abs(di) + std::abs(dj));
                                if (before > most) {
                                    most = before;
                                    from[static_cast<std::size_t>(k) * slice + n]
                                        = static_cast<std::int8_t>((dj + 1) * 3 + di + 1);
                                }
                            }
                    is_reached = is_reached || (here > kImpossible && most > kUnreached);
                    next[n] = static_cast<float>(std::max(most + here, kUnreached));
                }
            if (!is_reached)
                continue; // and nothing was noted in `from`
            has_begun = true;
            std::swap(best, next);
        }
        std::vector<std::array<int, 2>> path(static_cast<std::size_t>(nz));
        auto n = static_cast<int>(std::max_element(best.begin(), best.end()) - best.begin());
        for (int k = nz - 1; k >= 0; --k) {
            path[static_cast<std::size_t>(k)] = { n % nx, n / nx };
            const int step = from[static_cast<std::size_t>(k) * slice + static_cast<std::size_t>(n)];
            n += (step / 3 - 1) * nx + step % 3 - 1;
            n = std::clamp(n, 0, nx * ny - 1);
        }
        return path;
    }

    /// Finds the run of slices with the largest sum of (score - least).
    std::pair<int, int> best_run(const std::vector<double>& scores, double least)
    {
        std::pair<int, int> run { 0, -1 };
        double most = 0.0, sum = 0.0;
        int start = 0;
        for (int k = 0; k < static_cast<int>(scores.size()); ++k) {
            sum += scores[static_cast<std::size_t>(k)] - least;
            if (sum <= 0.0) {
                sum = 0.0;
                start = k + 1;
            } else if (sum > most) {
                most = sum;
                run = { start, k };
            }
        }
        return run;
    }

    MidlinePath smooth_path(
        const mesh::ImageGrid& grid, const std::vector<std::array<int, 2>>& voxels, std::pair<int, int> run)
    {
        constexpr int kHalf = 4;
        MidlinePath path;
        path.z0 = grid.origin.z();
        path.dz = grid.spacing.z();
        path.first = run.first;
        path.last = run.second;
        path.at.resize(voxels.size());
        for (int k = run.first; k <= run.second; ++k) {
            Eigen::Vector2d sum = Eigen::Vector2d::Zero();
            // A symmetric window keeps the ends in place.
            const int reach = std::min({ kHalf, k - run.first, run.second - k });
            for (int c = k - reach; c <= k + reach; ++c) {
                const auto& v = voxels[static_cast<std::size_t>(c)];
                sum += grid.world(Vec3(v[0], v[1], c)).head<2>();
            }
            path.at[static_cast<std::size_t>(k)] = sum / (2 * reach + 1);
        }
        return path;
    }

    template <typename Score>
    MidlinePath find_path(const mesh::ImageGrid& grid, double shift_cost, double least, const Score& score)
    {
        const auto voxels = best_path(grid, shift_cost, score);
        std::vector<double> scores;
        for (int k = 0; k < grid.size[2]; ++k)
            scores.push_back(std::max(
                -1.0, score(voxels[static_cast<std::size_t>(k)][0], voxels[static_cast<std::size_t>(k)][1], k)));
        return smooth_path(grid, voxels, best_run(scores, least));
    }

    /// Fits x as a line over z through the lower part of a path.
    Eigen::Vector2d line_through(const MidlinePath& path, double share)
    {
        const int end = path.first + std::max(1, static_cast<int>(share * (path.last - path.first)));
        double n = 0.0, sz = 0.0, szz = 0.0, sx = 0.0, sxz = 0.0;
        for (int k = path.first; k <= end; ++k) {
            const double z = path.z0 + path.dz * k, x = path.at[static_cast<std::size_t>(k)].x();
            n += 1.0;
            sz += z;
            szz += z * z;
            sx += x;
            sxz += x * z;
        }
        const double slope = (n * sxz - sx * sz) / (n * szz - sz * sz);
        return { (sx - slope * sz) / n, slope };
    }

    struct LungBox {
        double middle_x = 0.0, middle_y = 0.0, front_y = 0.0, back_y = 0.0;
    };
    LungBox lung_box(const CoarseImage& image)
    {
        Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
        std::size_t v = 0;
        for (int k = 0; k < image.grid.size[2]; ++k)
            for (int j = 0; j < image.grid.size[1]; ++j)
                for (int i = 0; i < image.grid.size[0]; ++i, ++v)
                    if (image.lungs[v]) {
                        const Vec3 p = image.grid.world(Vec3(i, j, k));
                        low = low.cwiseMin(p);
                        high = high.cwiseMax(p);
                    }
        return { 0.5 * (low.x() + high.x()), 0.5 * (low.y() + high.y()), low.y(), high.y() };
    }

} // namespace

MidlinePath find_spine(const CoarseImage& image)
{
    constexpr double kReachX = 50.0, kReachY = 45.0; // mm from the middle of the lungs; the neck lies farther forward
    constexpr double kShift = 0.06, kLeast = 0.35;
    const BoneMap bone(image, 9.0); // half a vertebra, which averages over the discs
    const LungBox lungs = lung_box(image);
    const mesh::ImageGrid& grid = image.grid;
    return find_path(grid, kShift, kLeast, [&](int i, int j, int k) {
        const double x = grid.origin.x() + grid.spacing.x() * i, y = grid.origin.y() + grid.spacing.y() * j;
        if (std::abs(x - lungs.middle_x) > kReachX || y < lungs.middle_y - kReachY || !image.body[grid.offset(i, j, k)])
            return 10.0 * kImpossible;
        const double body = bone.box(i, j, k, -12, 12, -11, 11);
        const double arch = bone.box(i, j, k, -10, 10, 18, 42);
        // Heart and aorta with contrast have bright neighbours; a vertebra has not.
        const double sides = bone.box(i, j, k, -38, -28, -10, 4) + bone.box(i, j, k, 28, 38, -10, 4);
        const double front = bone.box(i, j, k, -10, 10, -34, -25);
        return body + arch - 0.4 * sides - 0.4 * front;
    });
}

MidlinePath find_sternum(const CoarseImage& image, const MidlinePath& spine)
{
    constexpr double kReachX = 36.0; // mm from the spine's plane
    constexpr double kDeepest = 55.0; // mm under the skin
    constexpr double kShift = 0.05, kLeast = 0.22;
    const BoneMap bone(image, 6.0);
    const mesh::ImageGrid& grid = image.grid;
    // The first body voxel from the front, per column of each slice.
    std::vector<int> skin(
        static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[2]), grid.size[1]);
    for (int k = 0; k < grid.size[2]; ++k)
        for (int i = 0; i < grid.size[0]; ++i)
            for (int j = 0; j < grid.size[1]; ++j)
                if (image.body[grid.offset(i, j, k)]) {
                    skin[static_cast<std::size_t>(k * grid.size[0] + i)] = j;
                    break;
                }
    // The first pass may leave the sternum for a clavicle at its top. The lower part of the path gives the line for the
    // second pass.
    Eigen::Vector2d line(spine(grid.origin.z()).x(), 0.0); // x = line[0] + line[1] * z
    double per_mm = 0.002, per_mm2 = 0.0, reach = kReachX;
    bool follow_spine = true;
    const auto score = [&](int i, int j, int k) {
        const Vec3 p = grid.world(Vec3(i, j, k));
        const Eigen::Vector2d behind = spine(p.z());
        const double middle = follow_spine ? behind.x() : line[0] + line[1] * p.z();
        const double depth = (j - skin[static_cast<std::size_t>(k * grid.size[0] + i)]) * grid.spacing.y();
        if (std::abs(p.x() - middle) > reach || depth < 0.0 || depth > kDeepest || p.y() > behind.y() - 40.0)
            return 10.0 * kImpossible;
        const double plate = bone.box(i, j, k, -9, 9, -4, 4);
        const double back = bone.box(i, j, k, -12, 12, 10, 20);
        const double front = bone.box(i, j, k, -9, 9, -18, -10);
        return plate - 0.8 * back - 0.5 * front - per_mm * std::abs(p.x() - middle)
            - per_mm2 * (p.x() - middle) * (p.x() - middle);
    };
    const MidlinePath first = find_path(grid, kShift, kLeast, score);
    if (!first.found())
        return first;
    line = line_through(first, 0.65);
    follow_spine = false;
    per_mm = 0.006;
    per_mm2 = 0.0012; // the medial end of a clavicle is at least 15 mm off the line
    reach = 20.0;
    MidlinePath path = find_path(grid, kShift, kLeast, score);
    // Beside the jugular notch there is bone on both sides and no bone in the middle.
    constexpr double kOffLine = 8.0; // mm
    const auto off_line = [&](int k) {
        const double z = path.z0 + path.dz * k;
        return std::abs(path.at[static_cast<std::size_t>(k)].x() - line[0] - line[1] * z) > kOffLine;
    };
    while (path.last > path.first && off_line(path.last))
        --path.last;
    return path;
}

} // namespace retractor::datasets::segmentation
