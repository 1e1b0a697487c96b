#pragma once
// Voxel filters for the segmentation, with radii in mm. ITK is confined to one source file without Eigen, because ITK
// brings an older Eigen; this header therefore describes grids by plain numbers. Memory order: x fastest. Every filter
// requires one value per voxel of its extent.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace retractor::datasets::segmentation {

/// A grid without a place in the world.
struct Extent {
    std::array<int, 3> size { 0, 0, 0 }; ///< voxels along x, y, z
    std::array<double, 3> spacing { 1.0, 1.0, 1.0 }; ///< mm

    std::size_t voxel_count() const
    {
        return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1])
            * static_cast<std::size_t>(size[2]);
    }
};

/// One byte per voxel, 0 or 1.
using Mask = std::vector<std::uint8_t>;

/// Sets the number of threads of all filters in the process; the default is 2. @pre At least 1.
void set_filter_threads(int threads);

/// Sets voxels with a value in [low, high].
Mask threshold(std::span<const std::int16_t> values, int low, int high);

/// Euclidean distance (mm) from each voxel centre to the centre of the nearest set voxel, 0 in the mask. Without any
/// set voxel, every distance is the diagonal of the extent.
std::vector<float> distance_to(const Extent& extent, const Mask& mask);

/// Morphological operations with a ball of this radius. Voxels outside the extent count as unset for dilation and as
/// set for erosion, so that a body cut off by the border of the image does not shrink at the border.
/// @pre The radius is finite and not negative.
Mask dilated(const Extent& extent, const Mask& mask, double radius_mm);
Mask eroded(const Extent& extent, const Mask& mask, double radius_mm);
Mask opened(const Extent& extent, const Mask& mask, double radius_mm);
Mask closed(const Extent& extent, const Mask& mask, double radius_mm);

/// Pieces connected over faces, numbered from 1 in order of falling size.
struct Pieces {
    std::vector<std::int32_t> piece_of; ///< per voxel: number of the piece, 0 outside the mask
    std::vector<std::size_t> voxels; ///< voxels per piece; [0] belongs to piece 1
};
/// Finds all pieces of a mask.
Pieces connected_pieces(const Extent& extent, const Mask& mask);
/// The largest piece of a mask.
Mask largest_piece(const Extent& extent, const Mask& mask);
/// The pieces of `mask` that touch a voxel of `seeds`.
Mask reached_from(const Extent& extent, const Mask& mask, const Mask& seeds);

/// Sets unset voxels that the mask encloses in three dimensions.
Mask holes_filled(const Extent& extent, const Mask& mask);

/// Gaussian filter of standard deviation `sigma_mm`. @throws InputError for fewer than 4 voxels along an axis.
std::vector<std::int16_t> smoothed(const Extent& extent, std::span<const std::int16_t> values, double sigma_mm);

} // namespace retractor::datasets::segmentation
