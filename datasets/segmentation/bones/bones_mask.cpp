// Distinguishes bone from other bright structures. Cortex is found by a threshold; marrow is the tissue that cortex
// encloses. The outer rim of partly filled voxels is removed relative to the brightness of the nearest cortex, so that
// bones keep their thickness.

#include "datasets/segmentation/bones/bones_steps.h"
#include "datasets/segmentation/image/working_image.h"

#include <algorithm>
#include <cmath>

namespace retractor::datasets::segmentation {

namespace {

    constexpr int kSure = 220; ///< HU, smoothed; cortex or dense spongy bone
    constexpr int kPossible = 150; ///< HU; above soft tissue by several times the noise

    /// True deep inside the cage, where heart, vessels and organs may have contrast, and the spine is the only bone.
    bool in_cavity(const Cage& cage, const Vec3& p)
    {
        constexpr double kDeep = 15.0; // mm inside the hull; ribs lie farther out even where the hull is inaccurate
        if (cage.outside_at(p) > -kDeep)
            return false;
        const Eigen::Vector2d c = cage.spine(p.z());
        const double x = std::abs(p.x() - c.x()), y = p.y() - c.y();
        if (x < 50.0 && y > -4.0)
            return false; // heads and necks of ribs
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

    /// Removes rim voxels that are less than half as dense as the bone beside them.
    void peel(const WorkingImage& image, const std::vector<std::int16_t>& hu, Mask& bone)
    {
        constexpr double kSoftHu = 50.0, kHalf = 0.5;
        constexpr int kMostThreshold = 420; // dense cortex then does not remove the spongy ends of bones
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
    // Fills marrow and spinal canal, which are holes of the axial sections. Larger holes inside rings of several bones
    // stay.
    constexpr double kLargestHole = 1300.0; // mm2; a vertebral body with a thin shell
    bone = small_holes_filled_in_planes(image.extent(), bone, 2, kLargestHole);
    // Two passes, because neighbouring ribs and the joints between bones blur into each other over a few voxels.
    for (int pass = 0; pass < 2; ++pass)
        peel(image, smooth_hu, bone);
    return bone;
}

} // namespace retractor::datasets::segmentation
