// Bone told from everything else that is bright. Cortex is found by threshold; marrow is what it encloses; the outer
// rim of half-filled voxels is taken off by the height of the nearest cortex, so that bones keep their thickness.

#include "datasets/segmentation/bones_steps.h"

#include <algorithm>
#include <cmath>

namespace retractor::segmentation {

namespace {

    constexpr int kSure = 220; ///< HU, smoothed: cortex or dense spongy bone
    constexpr int kPossible = 150; ///< above soft tissue by several times the noise

    /// Contrast-filled heart, vessels and organs lie deep inside the cage, where no bone but the spine's is.
    bool in_cavity(const Cage& cage, const Vec3& p)
    {
        constexpr double kDeep = 15.0; // mm inside the hull: ribs stay further out even where the hull is loose
        if (cage.outside_at(p) > -kDeep)
            return false;
        const Eigen::Vector2d c = cage.spine(p.z());
        const double x = std::abs(p.x() - c.x()), y = p.y() - c.y();
        if (x < 50.0 && y > -4.0)
            return false; // heads and necks of the ribs
        return !in_spine_reach(cage, p) && !in_sternum_reach(cage, p);
    }

    /// Largest value in a box.
    std::int16_t largest_near(const WorkingImage& image, const std::vector<std::int16_t>& hu, Voxel v, int radius)
    {
        const auto nx = static_cast<Voxel>(image.grid.size[0]), ny = static_cast<Voxel>(image.grid.size[1]);
        const int i = static_cast<int>(v % nx), j = static_cast<int>((v / nx) % ny),
                  k = static_cast<int>(v / (nx * ny));
        std::int16_t most = hu[v];
        for (int c = std::max(0, k - radius); c <= std::min(image.grid.size[2] - 1, k + radius); ++c)
            for (int b = std::max(0, j - radius); b <= std::min(image.grid.size[1] - 1, j + radius); ++b) {
                const std::int16_t* row = hu.data() + image.grid.offset(0, b, c);
                for (int a = std::max(0, i - radius); a <= std::min(image.grid.size[0] - 1, i + radius); ++a)
                    most = std::max(most, row[a]);
            }
        return most;
    }

    /// Takes off rim voxels that are less than half as dense as the bone next to them.
    void peel(const WorkingImage& image, const std::vector<std::int16_t>& hu, Mask& bone)
    {
        constexpr double kSoftHu = 50.0, kHalf = 0.5;
        constexpr int kMostThreshold = 420; // so that dense cortex does not eat the spongy ends of bones
        const auto nx = static_cast<Voxel>(image.grid.size[0]);
        const Voxel slice = nx * static_cast<Voxel>(image.grid.size[1]);
        const int radius = std::max(1, static_cast<int>(std::lround(3.0 / image.grid.spacing.x())));
        std::vector<Voxel> off;
        for (Voxel v = slice + nx + 1; v + slice + nx + 1 < bone.size(); ++v) {
            if (!bone[v] || hu[v] > kMostThreshold)
                continue;
            if (bone[v - 1] && bone[v + 1] && bone[v - nx] && bone[v + nx] && bone[v - slice] && bone[v + slice])
                continue;
            const double dense = largest_near(image, hu, v, radius);
            if (hu[v] < std::min<double>(kMostThreshold, kSoftHu + kHalf * (dense - kSoftHu)))
                off.push_back(v);
        }
        for (const Voxel v : off)
            bone[v] = 0;
    }

    /// Marrow and the canal of the spine: holes of the sections, but not what rings of several bones enclose.
    void fill_small_holes(const ImageGrid& grid, Mask& bone)
    {
        constexpr double kLargest = 1300.0; // mm2: a vertebral body with a thin shell
        const int nx = grid.size[0], ny = grid.size[1];
        const double area = grid.spacing.x() * grid.spacing.y();
        std::vector<std::uint8_t> seen(static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny));
        std::vector<std::array<int, 2>> hole;
        for (int k = 0; k < grid.size[2]; ++k) {
            std::fill(seen.begin(), seen.end(), std::uint8_t { 0 });
            std::uint8_t* slice = bone.data() + grid.offset(0, 0, k);
            for (int j0 = 0; j0 < ny; ++j0)
                for (int i0 = 0; i0 < nx; ++i0) {
                    if (seen[static_cast<std::size_t>(j0 * nx + i0)] || slice[j0 * nx + i0])
                        continue;
                    hole.assign(1, { i0, j0 });
                    seen[static_cast<std::size_t>(j0 * nx + i0)] = 1;
                    bool open = false;
                    for (std::size_t n = 0; n < hole.size(); ++n) {
                        const auto [i, j] = hole[n];
                        constexpr std::array<std::array<int, 2>, 4> kSteps { { { 1, 0 }, { -1, 0 }, { 0, 1 },
                            { 0, -1 } } };
                        for (const auto& [di, dj] : kSteps) {
                            const int a = i + di, b = j + dj;
                            if (a < 0 || b < 0 || a >= nx || b >= ny) {
                                open = true;
                                continue;
                            }
                            auto& mark = seen[static_cast<std::size_t>(b * nx + a)];
                            if (mark || slice[b * nx + a])
                                continue;
                            mark = 1;
                            hole.push_back({ a, b });
                        }
                    }
                    if (!open && static_cast<double>(hole.size()) * area <= kLargest)
                        for (const auto& [i, j] : hole)
                            slice[j * nx + i] = 1;
                }
        }
    }

} // namespace

Mask bone_mask(const BonesInput& input, const Cage& cage, const std::vector<std::int16_t>& smooth_hu)
{
    const WorkingImage& image = input.image;
    Mask bone(smooth_hu.size(), 0), sure(smooth_hu.size(), 0);
    Voxel v = 0;
    for (int k = 0; k < image.grid.size[2]; ++k)
        for (int j = 0; j < image.grid.size[1]; ++j)
            for (int i = 0; i < image.grid.size[0]; ++i, ++v) {
                if (smooth_hu[v] < kPossible || !input.body[v] || in_cavity(cage, image.grid.world(Vec3(i, j, k))))
                    continue;
                bone[v] = 1;
                sure[v] = smooth_hu[v] >= kSure;
            }
    bone = reached_from(image.extent(), bone, sure);
    fill_small_holes(image.grid, bone);
    // Twice, since neighbouring ribs and the joints between bones blur into one another over a few voxels.
    for (int pass = 0; pass < 2; ++pass)
        peel(image, smooth_hu, bone);
    return bone;
}

} // namespace retractor::segmentation
