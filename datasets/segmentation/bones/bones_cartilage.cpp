// Finds the costal cartilages. A cartilage runs from a rib's front end to the sternum (ribs 1 to 7) or to the cartilage
// above (ribs 8 to 10), along the cheapest path. Cartilage is a little denser than muscle, so the path follows visible
// cartilage. Elsewhere the path runs through the rib cage as straight as possible, and the result is marked as rough.

#include "datasets/segmentation/bones/bones_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace retractor::datasets::segmentation {

namespace {

    constexpr int kLastToSternum = 7, kLast = 10;
    constexpr double kSeenLow = 78.0; ///< HU of cartilage, also calcified; muscle has 50 to 60
    constexpr double kInnerShell = -6.0, kOuterShell = 18.0; ///< mm outside the hull of the lungs

    /// Relative cost of one millimetre of path.
    double cost_of(double hu)
    {
        constexpr double kMuscle = 45.0, kHidden = 5.0, kFat = 6.0;
        if (hu >= kSeenLow)
            return 1.0;
        if (hu < kMuscle)
            return kFat;
        return 1.0 + (kHidden - 1.0) * (kSeenLow - hu) / (kSeenLow - kMuscle);
    }

    /// The height (mm) at which the cartilage of a rib meets the sternum. The table gives the distance from the top as
    /// a share of the sternum's length.
    double joint_height(const Cage& cage, int rib)
    {
        constexpr std::array<double, kLastToSternum> kShare { 0.10, 0.27, 0.40, 0.53, 0.64, 0.73, 0.80 };
        return cage.sternum.top()
            - kShare[static_cast<std::size_t>(rib - 1)] * (cage.sternum.top() - cage.sternum.bottom());
    }

    /// Shortest paths on the coarse grid.
    class PathSearch {
    public:
        PathSearch(const CoarseImage& image, const Cage& cage, bool left)
            : image_(image)
            , step_cost_(image.grid.voxel_count(), 0.0F)
        {
            constexpr int kAir = -300;
            std::size_t v = 0;
            for (int k = 0; k < image.grid.size[2]; ++k)
                for (int j = 0; j < image.grid.size[1]; ++j)
                    for (int i = 0; i < image.grid.size[0]; ++i, ++v) {
                        const Vec3 p = image.grid.world(Vec3(i, j, k));
                        const Eigen::Vector2d centre = cage.centre(p.z());
                        if (!image.body[v] || image.lungs[v] || image.hu[v] < kAir || p.y() > centre.y()
                            || cage.outside[v] < kInnerShell || cage.outside[v] > kOuterShell
                            || (p.x() > cage.sternum(p.z()).x()) != left)
                            continue;
                        step_cost_[v] = static_cast<float>(cost_of(image.hu[v]));
                    }
        }

        /// Blocks the surroundings of a path for all further paths.
        void block(const std::vector<Vec3>& path, double radius)
        {
            for (const Vec3& p : path)
                for_near(p, radius, [&](std::size_t v) { step_cost_[v] = 0.0F; });
        }

        /// The cheapest path from a point to one of the targets (voxel -> extra cost). Empty when no path exists.
        std::vector<Vec3> path(const Vec3& from, const std::vector<std::pair<std::size_t, double>>& targets) const
        {
            const mesh::ImageGrid& grid = image_.grid;
            const auto nx = static_cast<std::ptrdiff_t>(grid.size[0]), nxy = nx * grid.size[1];
            std::vector<float> best(step_cost_.size(), std::numeric_limits<float>::infinity());
            std::vector<float> extra(step_cost_.size(), -1.0F);
            for (const auto& [v, cost] : targets)
                extra[v] = static_cast<float>(cost);
            std::vector<std::int32_t> before(step_cost_.size(), -1);
            using Entry = std::pair<float, std::size_t>;
            std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
            constexpr double kStart = 7.0; // mm; the path may begin anywhere on the rib's end
            for_near(from, kStart, [&](std::size_t v) {
                best[v] = 0.0F;
                queue.push({ 0.0F, v });
            });
            float end_cost = std::numeric_limits<float>::infinity();
            std::size_t end = 0;
            while (!queue.empty()) {
                const auto [cost, v] = queue.top();
                queue.pop();
                if (cost > best[v])
                    continue;
                if (cost >= end_cost)
                    break;
                if (extra[v] >= 0.0F && cost + extra[v] < end_cost) {
                    end_cost = cost + extra[v];
                    end = v;
                }
                const int i = static_cast<int>(v % static_cast<std::size_t>(nx));
                const int j = static_cast<int>(v / static_cast<std::size_t>(nx)) % grid.size[1];
                const int k = static_cast<int>(v / static_cast<std::size_t>(nxy));
                for (int n = 0; n < 27; ++n) {
                    const int di = n % 3 - 1, dj = n / 3 % 3 - 1, dk = n / 9 - 1;
                    if (!grid.contains(i + di, j + dj, k + dk))
                        continue;
                    const auto u = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(v) + di + dj * nx + dk * nxy);
                    const float weight = extra[u] >= 0.0F ? 1.0F : step_cost_[u];
                    if (weight <= 0.0F)
                        continue;
                    const auto next = static_cast<float>(
                        cost + weight * grid.spacing.x() * std::sqrt(static_cast<double>(di * di + dj * dj + dk * dk)));
                    if (next < best[u]) {
                        best[u] = next;
                        before[u] = static_cast<std::int32_t>(v);
                        queue.push({ next, u });
                    }
                }
            }
            std::vector<Vec3> points;
            if (end_cost == std::numeric_limits<float>::infinity())
                return points;
            for (auto v = static_cast<std::int32_t>(end); v >= 0; v = before[static_cast<std::size_t>(v)])
                points.push_back(position(static_cast<std::size_t>(v)));
            points.push_back(from);
            std::reverse(points.begin(), points.end());
            return points;
        }

        Vec3 position(std::size_t v) const
        {
            const auto nx = static_cast<std::size_t>(image_.grid.size[0]);
            const auto ny = static_cast<std::size_t>(image_.grid.size[1]);
            return image_.grid.world(Vec3(
                static_cast<double>(v % nx), static_cast<double>((v / nx) % ny), static_cast<double>(v / (nx * ny))));
        }
        double hu_at(const Vec3& p) const
        {
            const Vec3 x = image_.grid.index(p);
            const int i = static_cast<int>(std::lround(x[0])), j = static_cast<int>(std::lround(x[1]));
            const int k = static_cast<int>(std::lround(x[2]));
            return image_.grid.contains(i, j, k) ? image_.hu[image_.grid.offset(i, j, k)] : -1000.0;
        }

        template <typename Visit> void for_near(const Vec3& p, double radius, const Visit& visit) const
        {
            const mesh::ImageGrid& grid = image_.grid;
            const Vec3 low = grid.index(p.array() - radius), high = grid.index(p.array() + radius);
            for (int k = static_cast<int>(std::ceil(low[2])); k <= high[2]; ++k)
                for (int j = static_cast<int>(std::ceil(low[1])); j <= high[1]; ++j)
                    for (int i = static_cast<int>(std::ceil(low[0])); i <= high[0]; ++i)
                        if (grid.contains(i, j, k) && (grid.world(Vec3(i, j, k)) - p).norm() <= radius)
                            visit(grid.offset(i, j, k));
        }

    private:
        const CoarseImage& image_;
        std::vector<float> step_cost_; ///< cost per mm; 0 blocks a voxel
    };

    std::vector<Vec3> smooth_line(std::vector<Vec3> line)
    {
        for (int pass = 0; pass < 4; ++pass)
            for (std::size_t n = 1; n + 1 < line.size(); ++n)
                line[n] = 0.25 * line[n - 1] + 0.5 * line[n] + 0.25 * line[n + 1];
        return line;
    }

    std::vector<std::pair<std::size_t, double>> sternum_targets(const CoarseImage& image, const Cage& cage,
        const mesh::ImageGrid& grid, const std::vector<Label>& labels, Label sternum, bool left, double z)
    {
        constexpr double kPerMm = 0.6; // cost per mm for meeting the sternum too high or too low
        std::vector<std::pair<std::size_t, double>> targets;
        for (int k = 0; k < image.grid.size[2]; ++k)
            for (int j = 0; j < image.grid.size[1]; ++j)
                for (int i = 0; i < image.grid.size[0]; ++i) {
                    const Vec3 p = image.grid.world(Vec3(i, j, k));
                    const Vec3 x = grid.index(p);
                    const int a = static_cast<int>(std::lround(x[0])), b = static_cast<int>(std::lround(x[1]));
                    const int c = static_cast<int>(std::lround(x[2]));
                    if (grid.contains(a, b, c) && labels[grid.offset(a, b, c)] == sternum
                        && (p.x() > cage.sternum(p.z()).x()) == left)
                        targets.emplace_back(image.grid.offset(i, j, k), kPerMm * std::abs(p.z() - z));
                }
        return targets;
    }

    /// Labels the surroundings of a path: a rod regardless of the image, and neighbouring voxels that look like
    /// cartilage or its calcified rim.
    void paint(const WorkingImage& image, const Cage& cage, const Mask& bone,
        const std::vector<std::int16_t>& smooth_hu, const std::vector<Vec3>& path, Label sternum, Label cartilage,
        std::vector<Label>& labels)
    {
        constexpr double kRod = 4.0, kReach = 7.5; // mm; cartilages are 8 to 12 mm thick
        const mesh::ImageGrid& grid = image.grid;
        const auto mean_hu = [&](int i, int j, int k) {
            int sum = 0;
            for (int n = 0; n < 27; ++n)
                sum += smooth_hu[grid.offset(i + n % 3 - 1, j + n / 3 % 3 - 1, k + n / 9 - 1)];
            return sum / 27;
        };
        for (const Vec3& p : path) {
            const Vec3 x = grid.index(p);
            const int a = static_cast<int>(std::lround(x[0])), b = static_cast<int>(std::lround(x[1]));
            const int c = static_cast<int>(std::lround(x[2]));
            if (grid.contains(a, b, c) && labels[grid.offset(a, b, c)] == sternum)
                continue; // the joint is reached
            const Vec3 low = grid.index(p.array() - kReach), high = grid.index(p.array() + kReach);
            for (int k = static_cast<int>(std::ceil(low[2])); k <= high[2]; ++k)
                for (int j = static_cast<int>(std::ceil(low[1])); j <= high[1]; ++j)
                    for (int i = static_cast<int>(std::ceil(low[0])); i <= high[0]; ++i) {
                        if (i < 1 || j < 1 || k < 1 || i + 1 >= grid.size[0] || j + 1 >= grid.size[1]
                            || k + 1 >= grid.size[2])
                            continue;
                        const Voxel v = grid.offset(i, j, k);
                        const Vec3 q = grid.world(Vec3(i, j, k));
                        const double off = (q - p).norm();
                        if (labels[v] != 0 || off > kReach || cage.outside_at(q) < kInnerShell)
                            continue;
                        if (off <= kRod || bone[v] || mean_hu(i, j, k) > kSeenLow)
                            labels[v] = cartilage;
                    }
        }
    }

    /// Removes small pieces of noise beside the paths.
    void drop_crumbs(const WorkingImage& image, Label cartilage, std::vector<Label>& labels)
    {
        constexpr double kCrumb = 400.0; // mm3
        Mask mask(labels.size());
        for (Voxel v = 0; v < labels.size(); ++v)
            mask[v] = labels[v] == cartilage;
        const Pieces pieces = connected_pieces(image.extent(), mask);
        for (Voxel v = 0; v < labels.size(); ++v)
            if (mask[v]
                && static_cast<double>(pieces.voxels[static_cast<std::size_t>(pieces.piece_of[v]) - 1])
                        * image.grid.voxel_volume()
                    < kCrumb)
                labels[v] = 0;
    }

    std::vector<Vec3> densely(const std::vector<Vec3>& line)
    {
        std::vector<Vec3> points;
        for (std::size_t n = 0; n + 1 < line.size(); ++n)
            for (const double t : { 0.0, 0.5 })
                points.push_back((1.0 - t) * line[n] + t * line[n + 1]);
        points.push_back(line.back());
        return points;
    }

} // namespace

std::vector<CartilagePath> add_cartilages(const WorkingImage& image, const CoarseImage& coarse, const Cage& cage,
    const Mask& bone, const std::vector<std::int16_t>& smooth_hu, const std::vector<RibTrack>& ribs, Label sternum,
    Label cartilage, std::vector<Label>& labels)
{
    constexpr double kBorder = 12.0, kFrontDeg = 85.0, kSideDeg = 65.0, kKeepApart = 7.0, kLongest = 150.0,
                     kTouching = 10.0; // mm, degrees
    std::vector<CartilagePath> paths;
    for (const bool left : { true, false }) {
        PathSearch search(coarse, cage, left);
        std::vector<Vec3> above;
        for (int number = 1; number <= kLast; ++number) {
            const auto rib = std::find_if(
                ribs.begin(), ribs.end(), [&](const RibTrack& r) { return r.left == left && r.number == number; });
            if (rib == ribs.end())
                continue;
            const Vec3 end = rib->line.back();
            const double bottom = image.grid.origin.z();
            CartilagePath path { .left = left, .number = number };
            if (end.z() < bottom + kBorder || rib->angle.back() < (number <= kLastToSternum ? kFrontDeg : kSideDeg)) {
                paths.push_back(path); // the rib's end was not seen
                continue;
            }
            std::vector<std::pair<std::size_t, double>> targets;
            if (number <= kLastToSternum)
                targets = sternum_targets(coarse, cage, image.grid, labels, sternum, left, joint_height(cage, number));
            else
                for (std::size_t n = above.size() / 5; n < above.size(); ++n)
                    search.for_near(above[n], 5.0, [&](std::size_t v) { targets.emplace_back(v, 0.0); });
            std::vector<Vec3> line = search.path(end, targets);
            double length = 0.0, seen = 0.0;
            for (std::size_t n = 1; n < line.size(); ++n) {
                const double step = (line[n] - line[n - 1]).norm();
                length += step;
                seen += search.hu_at(line[n]) > kSeenLow ? step : 0.0;
            }
            if (line.size() >= 2 && length < kLongest) {
                line = smooth_line(std::move(line));
                path.line = line;
                path.seen = length > kTouching ? seen / length : 1.0;
                paint(image, cage, bone, smooth_hu, densely(line), sternum, cartilage, labels);
                // The next cartilage may come near this cartilage only at its end, where the two join.
                search.block(line, kKeepApart);
                above = std::move(line);
            }
            paths.push_back(std::move(path));
        }
    }
    drop_crumbs(image, cartilage, labels);
    return paths;
}

} // namespace retractor::datasets::segmentation
