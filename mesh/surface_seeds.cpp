#include "mesh/surface_seeds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <unordered_map>

namespace retractor {

namespace {

    constexpr double kSeedTolerance = 0.01; ///< mm; far below any facet distance
    constexpr double kSeedSpacing = 3.0; ///< edge lengths between seeds: sparse, so that refinement decides the rest
    constexpr double kExtremeSpacing = 0.7; ///< edge lengths between the extreme points of a small component
    constexpr std::size_t kSmallestComponent = 6; ///< voxels; smaller ones vanish when smoothed

    std::uint32_t find_root(std::vector<std::uint32_t>& parent, std::uint32_t at)
    {
        while (parent[at] != at) {
            parent[at] = parent[parent[at]];
            at = parent[at];
        }
        return at;
    }

    /// Root voxel of the face-connected component of each voxel.
    std::vector<std::uint32_t> components(const WallVoxels& wall)
    {
        std::vector<std::uint32_t> parent(wall.voxels.size());
        std::iota(parent.begin(), parent.end(), 0U);
        const std::size_t strides[3] = { 1, wall.offset(0, 1, 0), wall.offset(0, 0, 1) };
        for (std::size_t at = 0; at < parent.size(); ++at)
            if (wall.voxels[at] != 0) // the margin makes at - stride legal for every voxel inside
                for (const std::size_t stride : strides)
                    if (wall.voxels[at - stride] == wall.voxels[at]) {
                        const std::uint32_t a = find_root(parent, static_cast<std::uint32_t>(at));
                        const std::uint32_t b = find_root(parent, static_cast<std::uint32_t>(at - stride));
                        parent[std::max(a, b)] = std::min(a, b);
                    }
        for (std::size_t at = 0; at < parent.size(); ++at)
            parent[at] = find_root(parent, static_cast<std::uint32_t>(at));
        return parent;
    }

    /// Points no nearer to one another than asked, in a hash of cells.
    class SparsePoints {
    public:
        explicit SparsePoints(double cell)
            : cell_(cell)
        {
        }
        bool add(const Vec3& p, double distance)
        {
            const int reach = static_cast<int>(std::ceil(distance / cell_));
            const auto c = cell_of(p);
            for (int z = -reach; z <= reach; ++z)
                for (int y = -reach; y <= reach; ++y)
                    for (int x = -reach; x <= reach; ++x) {
                        const auto found = cells_.find(key({ c[0] + x, c[1] + y, c[2] + z }));
                        if (found == cells_.end())
                            continue;
                        for (const Vec3& other : found->second)
                            if ((other - p).norm() < distance)
                                return false;
                    }
            cells_[key(c)].push_back(p);
            return true;
        }

    private:
        std::array<std::int64_t, 3> cell_of(const Vec3& p) const
        {
            return { static_cast<std::int64_t>(std::floor(p[0] / cell_)), static_cast<std::int64_t>(std::floor(p[1] / cell_)),
                static_cast<std::int64_t>(std::floor(p[2] / cell_)) };
        }
        static std::int64_t key(const std::array<std::int64_t, 3>& c)
        {
            constexpr std::int64_t kBias = 1 << 20;
            return ((c[0] + kBias) << 42) + ((c[1] + kBias) << 21) + (c[2] + kBias);
        }
        double cell_;
        std::unordered_map<std::int64_t, std::vector<Vec3>> cells_;
    };

    /// The interface between two neighbouring voxels, when the smooth labels agree with the voxels' own.
    std::optional<SurfaceSeed> seed_between(const LabelField& field, const Vec3& here, int a, const Vec3& there, int b)
    {
        if (field.at(here) != a || field.at(there) != b)
            return std::nullopt;
        const Vec3 point = field.crossing(here, there, kSeedTolerance);
        return SurfaceSeed { point, std::min(a, b), std::max(a, b) };
    }

} // namespace

std::vector<SurfaceSeed> surface_seeds(const LabelField& field, const SizeField& size)
{
    const WallVoxels& wall = field.wall();
    const std::vector<std::uint32_t> component = components(wall);
    struct Extremes {
        std::size_t voxels = 0;
        std::array<std::optional<SurfaceSeed>, 6> points; ///< lowest and highest along i, j, k
    };
    std::unordered_map<std::uint32_t, Extremes> extremes;
    std::vector<std::uint32_t> order; // components in the order met: the map's own order is not ours to rely on
    std::vector<SurfaceSeed> candidates;

    const auto note_extreme = [&](std::uint32_t root, std::size_t which, const SurfaceSeed& seed) {
        const auto axis = static_cast<Eigen::Index>(which / 2);
        std::optional<SurfaceSeed>& kept = extremes[root].points[which];
        const bool better = !kept || (which % 2 == 0 ? seed.point[axis] < kept->point[axis] : seed.point[axis] > kept->point[axis]);
        if (better)
            kept = seed;
    };
    for (int k = 1; k + 1 < wall.size[2]; ++k)
        for (int j = 1; j + 1 < wall.size[1]; ++j)
            for (int i = 1; i + 1 < wall.size[0]; ++i) {
                const std::size_t at = wall.offset(i, j, k);
                if (wall.voxels[at] == 0)
                    continue;
                Extremes& mine = extremes[component[at]];
                if (mine.voxels++ == 0)
                    order.push_back(component[at]);
                for (std::size_t which = 0; which < 6; ++which) {
                    const int step = which % 2 == 0 ? -1 : 1;
                    std::array<int, 3> other { i, j, k };
                    other[which / 2] += step;
                    const std::size_t beside = wall.offset(other[0], other[1], other[2]);
                    if (wall.voxels[beside] == wall.voxels[at])
                        continue;
                    const auto seed = seed_between(field, wall.centre(i, j, k), wall.voxels[at],
                        wall.centre(other[0], other[1], other[2]), wall.voxels[beside]);
                    if (!seed)
                        continue;
                    note_extreme(component[at], which, *seed);
                    candidates.push_back(*seed);
                }
            }

    std::vector<SurfaceSeed> seeds;
    SparsePoints taken(10.0);
    const auto take = [&](const SurfaceSeed& seed, double edges) {
        if (taken.add(seed.point, edges * size.edge(seed.point, seed.a, seed.b)))
            seeds.push_back(seed);
    };
    for (const std::uint32_t root : order)
        if (const Extremes& found = extremes[root]; found.voxels >= kSmallestComponent)
            for (const auto& point : found.points)
                if (point)
                    take(*point, kExtremeSpacing);
    for (const SurfaceSeed& seed : candidates)
        take(seed, kSeedSpacing);
    return seeds;
}

} // namespace retractor
