#include "mesh/generation/surface_seeds.h"

#include "mesh/base/disjoint_sets.h"
#include "mesh/base/spatial_hash.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <random>
#include <unordered_map>

namespace retractor::mesh {

namespace {

    constexpr double kSeedTolerance = 0.01; ///< mm; far below any facet distance
    constexpr double kSeedSpacing = 2.0; ///< edge lengths between seeds; sparse, so that refinement decides the rest
    /// Largest spacing as a share of a small component's longest side, so that points lie all round the component.
    constexpr double kSpacingPerExtent = 0.5;
    /// mm; about a usual spacing, so that a search looks into few cells. The seeds do not depend on it.
    constexpr double kCell = 16.0;
    constexpr std::size_t kSmallestComponent = 6; ///< voxels; smaller components vanish by smoothing

    /// Root voxel of the face-connected component of each voxel.
    std::vector<std::uint32_t> components(const WallVoxels& wall)
    {
        DisjointSets<std::uint32_t> sets(wall.voxels.size());
        const std::size_t strides[3] = { 1, wall.offset(0, 1, 0), wall.offset(0, 0, 1) };
        for (std::size_t at = 0; at < wall.voxels.size(); ++at)
            if (wall.voxels[at] != 0) // the margin keeps at - stride in range for every voxel inside
                for (const std::size_t stride : strides)
                    if (wall.voxels[at - stride] == wall.voxels[at])
                        sets.join(static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(at - stride));
        return sets.roots();
    }

    /// Points that keep a distance from each other.
    class PointsApart {
    public:
        /// Adds a point unless another point is nearer than `distance` (mm).
        bool add(const Vec3& p, double distance)
        {
            // What was too near to the last point mostly is to its neighbour.
            if ((too_near_ - p).norm() < distance)
                return false;
            const auto is_apart = [&](const Vec3& other) {
                if ((other - p).norm() >= distance)
                    return true;
                too_near_ = other;
                return false;
            };
            if (!points_.visit_near(p, distance, is_apart))
                return false;
            points_.add(p, p);
            return true;
        }

    private:
        SpatialHash<Vec3> points_ { kCell };
        Vec3 too_near_ = Vec3::Constant(std::numeric_limits<double>::infinity());
    };

    struct Extent {
        std::size_t voxels = 0;
        Eigen::AlignedBox3i box;
    };

    /// Voxel count and bounding box of each component, by its root.
    std::unordered_map<std::uint32_t, Extent> extents(
        const WallVoxels& wall, const std::vector<std::uint32_t>& component)
    {
        std::unordered_map<std::uint32_t, Extent> found;
        for (int k = 0; k < wall.size[2]; ++k)
            for (int j = 0; j < wall.size[1]; ++j)
                for (int i = 0; i < wall.size[0]; ++i) {
                    const std::size_t at = wall.offset(i, j, k);
                    if (wall.voxels[at] == 0)
                        continue;
                    Extent& extent = found[component[at]];
                    ++extent.voxels;
                    extent.box.extend(Eigen::Vector3i(i, j, k));
                }
        return found;
    }

    /// A seed on the interface between two neighbouring voxels, when the smooth labels agree with the voxels' labels.
    std::optional<SurfaceSeed> seed_between(
        const LabelField& field, const Vec3& here, int label_here, const Vec3& there, int label_there)
    {
        const int a = field.merged(label_here, here), b = field.merged(label_there, there);
        if (a == b || field.at(here) != a || field.at(there) != b)
            return std::nullopt;
        const Vec3 point = field.crossing(here, there, kSeedTolerance);
        return SurfaceSeed { point, std::min(a, b), std::max(a, b) };
    }

    /// A voxel with a neighbour of another label on one of its six sides.
    struct Border {
        int i, j, k;
        std::size_t side;
    };

} // namespace

std::vector<SurfaceSeed> surface_seeds(const LabelField& field, const SizeField& size, unsigned order)
{
    const WallVoxels& wall = field.wall();
    const std::vector<std::uint32_t> component = components(wall);
    const auto extent_of = extents(wall, component);
    constexpr std::array<std::array<int, 3>, 6> kSides { { { -1, 0, 0 }, { 1, 0, 0 }, { 0, -1, 0 }, { 0, 1, 0 },
        { 0, 0, -1 }, { 0, 0, 1 } } };

    std::vector<Border> borders;
    for (int k = 1; k + 1 < wall.size[2]; ++k)
        for (int j = 1; j + 1 < wall.size[1]; ++j)
            for (int i = 1; i + 1 < wall.size[0]; ++i) {
                const std::size_t at = wall.offset(i, j, k);
                if (wall.voxels[at] == 0)
                    continue;
                for (std::size_t s = 0; s < kSides.size(); ++s)
                    if (wall.voxels[wall.offset(i + kSides[s][0], j + kSides[s][1], k + kSides[s][2])]
                        != wall.voxels[at])
                        borders.push_back({ i, j, k, s });
            }
    if (order != 0)
        std::shuffle(borders.begin(), borders.end(), std::mt19937(order));

    std::vector<SurfaceSeed> seeds;
    PointsApart taken;
    for (const auto& [i, j, k, s] : borders) {
        const std::size_t at = wall.offset(i, j, k);
        const Extent& extent = extent_of.at(component[at]);
        if (extent.voxels < kSmallestComponent)
            continue;
        const std::array<int, 3>& side = kSides[s];
        const std::size_t beside = wall.offset(i + side[0], j + side[1], k + side[2]);
        const auto seed = seed_between(field, wall.centre(i, j, k), wall.voxels[at],
            wall.centre(i + side[0], j + side[1], k + side[2]), wall.voxels[beside]);
        if (!seed)
            continue;
        const double longest = ((extent.box.sizes().array() + 1).cast<double>() * wall.spacing.array()).maxCoeff();
        const double spacing
            = std::min(kSeedSpacing * size.edge(seed->point, seed->a, seed->b), kSpacingPerExtent * longest);
        if (taken.add(seed->point, spacing))
            seeds.push_back(*seed);
    }
    return seeds;
}

} // namespace retractor::mesh
