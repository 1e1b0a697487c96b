#pragma once
// The grid that the segmentation works on, and the small tools that all steps share. Axes are patient LPS: x to the
// patient's left, y posterior, z superior. Units mm and Hounsfield units.

#include "datasets/segmentation/image/image_filters.h"
#include "mesh/image/volume.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace retractor::datasets::segmentation {

inline constexpr std::int16_t kOutsideHu = -1024; ///< what the scanner did not see

/// What the steps share: the CT on the working grid, whose axes are patient LPS (direction is the identity).
struct WorkingImage {
    mesh::ImageGrid grid;
    std::vector<std::int16_t> hu;

    Extent extent() const { return { grid.size, { grid.spacing.x(), grid.spacing.y(), grid.spacing.z() } }; }
};

/// The CT on an even grid over its box in the world. Voxels finer than the grid are averaged first, so that noise and
/// thin layers are not lost between samples; outside the CT is kOutsideHu.
WorkingImage working_image(const mesh::Volume& ct, double spacing_mm, int threads);

/// How many voxels working_image() would have: those of the box along the world's axes round the CT, which for a turned
/// CT is larger than the CT's own.
double working_voxels(const mesh::ImageGrid& ct, double spacing_mm);

/// Calls work(k) for k in [0, count), from several threads. When a call throws, no further ones begin, and the first
/// exception comes out here.
void for_planes(int count, int threads, const std::function<void(int)>& work);

double volume_ml(const Extent& extent, const Mask& mask);
std::size_t count_set(const Mask& mask);

Mask united(const Mask& a, const Mask& b);
Mask common(const Mask& a, const Mask& b);
Mask without(const Mask& a, const Mask& b);

/// A grid with cells of `factor` voxels a side, for steps whose radius is far larger than a voxel.
Extent coarse_extent(const Extent& extent, int factor);
/// A cell is set when at least this share of its voxels is; at 0, when any is.
Mask coarse_mask(const Extent& extent, const Mask& mask, int factor, double share);
/// Each voxel takes the value of its cell.
template <typename Value>
std::vector<Value> fine_values(const Extent& extent, const std::vector<Value>& coarse, int factor);

/// More than half of the box of (2 radius_voxels + 1)^3; outside the grid counts as its border does.
Mask majority(const Extent& extent, const Mask& mask, int radius_voxels, int threads);

/// One voxel off every face.
Mask shrunk_by_a_voxel(const Extent& extent, const Mask& mask);
/// Voxels of `limit` that are set or have a neighbour over a face that is set.
Mask grown_by_a_voxel(const Extent& extent, const Mask& mask, const Mask& limit);

/// Enclosed areas of at most `most_mm2` in the planes square to one axis.
Mask small_holes_filled_in_planes(const Extent& extent, const Mask& mask, int axis, double most_mm2);
/// Enclosed areas of at most `most_mm2` in the planes square to each of the three axes.
Mask small_holes_filled(const Extent& extent, const Mask& mask, double most_mm2);

template <typename Value>
std::vector<Value> fine_values(const Extent& extent, const std::vector<Value>& coarse, int factor)
{
    const Extent cells = coarse_extent(extent, factor);
    std::vector<Value> out(extent.voxel_count());
    std::size_t v = 0;
    for (int k = 0; k < extent.size[2]; ++k)
        for (int j = 0; j < extent.size[1]; ++j) {
            const std::size_t row = (static_cast<std::size_t>(k / factor) * static_cast<std::size_t>(cells.size[1])
                                        + static_cast<std::size_t>(j / factor))
                * static_cast<std::size_t>(cells.size[0]);
            for (int i = 0; i < extent.size[0]; ++i, ++v)
                out[v] = coarse[row + static_cast<std::size_t>(i / factor)];
        }
    return out;
}

} // namespace retractor::datasets::segmentation
