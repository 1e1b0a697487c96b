#pragma once
// The grid on which the segmentation works, and small functions that all steps share. Axes are patient LPS: x to the
// patient's left, y posterior, z superior. Units mm and Hounsfield units.

#include "datasets/segmentation/image/image_filters.h"
#include "mesh/image/volume.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace retractor::datasets::segmentation {

inline constexpr std::int16_t kOutsideHu = -1024; ///< value of voxels outside the CT

/// The CT on the working grid, whose axes are patient LPS (the direction is the identity).
struct WorkingImage {
    mesh::ImageGrid grid;
    std::vector<std::int16_t> hu;

    Extent extent() const { return { grid.size, { grid.spacing.x(), grid.spacing.y(), grid.spacing.z() } }; }
};

/// The planes at the head's and the foot's end of a CT that have one value throughout: images are padded so where they
/// were moved onto others. Along the axis of the grid that lies nearest to head and feet. An image of one value has
/// none.
struct EmptyEnds {
    int axis = 2;
    int before = 0, after = 0; ///< number of planes
};
EmptyEnds empty_ends(const mesh::Volume& ct);
/// The CT without these planes. The body does not end there, so no skin lies there.
mesh::Volume without(const mesh::Volume& ct, const EmptyEnds& ends);

/// Resamples the CT to an isotropic grid over the CT's box in the world. Voxels finer than the grid are averaged first,
/// so that noise does not grow and thin layers do not fall between samples. Voxels outside the CT have kOutsideHu.
WorkingImage working_image(const mesh::Volume& ct, double spacing_mm, int threads);

/// The number of voxels of working_image(). The grid fills the CT's bounding box along the world's axes. For a rotated
/// CT this box is larger than the CT.
double working_voxels(const mesh::ImageGrid& ct, double spacing_mm);

/// Calls work(k) for k in [0, count) on several threads. After an exception no further call begins, and for_planes()
/// throws the first exception.
void for_planes(int count, int threads, const std::function<void(int)>& work);

/// Volume of a mask, ml.
double volume_ml(const Extent& extent, const Mask& mask);
/// Number of set voxels.
std::size_t count_set(const Mask& mask);

/// Union, intersection and difference (a without b) of two masks.
Mask united(const Mask& a, const Mask& b);
Mask common(const Mask& a, const Mask& b);
Mask without(const Mask& a, const Mask& b);

/// A grid with cells of `factor` voxels along each side, for steps with radii far larger than a voxel.
Extent coarse_extent(const Extent& extent, int factor);
/// Sets a cell when at least this share of its voxels is set; share 0 needs one set voxel.
Mask coarse_mask(const Extent& extent, const Mask& mask, int factor, double share);
/// Returns the value of its cell for each voxel.
template <typename Value>
std::vector<Value> fine_values(const Extent& extent, const std::vector<Value>& coarse, int factor);

/// Sets a voxel when more than half of its box of (2 radius_voxels + 1)^3 voxels is set. Values at the border are
/// repeated outside the grid.
Mask majority(const Extent& extent, const Mask& mask, int radius_voxels, int threads);

/// Removes one voxel at every face of the mask.
Mask shrunk_by_a_voxel(const Extent& extent, const Mask& mask);
/// Sets the voxels of `limit` that are set in `mask` or have a set neighbour over a face.
Mask grown_by_a_voxel(const Extent& extent, const Mask& mask, const Mask& limit);

/// Fills enclosed areas of at most `most_mm2` in the planes perpendicular to one axis.
Mask small_holes_filled_in_planes(const Extent& extent, const Mask& mask, int axis, double most_mm2);
/// Fills enclosed areas of at most `most_mm2` in the planes perpendicular to each of the three axes.
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
