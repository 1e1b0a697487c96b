#pragma once
// Voxel filters that the segmentation is made of, with radii in mm. The border to the filter library (ITK): it keeps
// ITK in one source file, which must not see Eigen (ITK brings an older one of its own), so grids are plain numbers
// here. Memory order: x fastest. Every filter checks that sizes agree and throws InputError when they do not.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace retractor::datasets::segmentation {

/// A grid without its place in the world.
struct Extent {
    std::array<int, 3> size { 0, 0, 0 };
    std::array<double, 3> spacing { 1.0, 1.0, 1.0 }; ///< mm

    std::size_t voxel_count() const
    {
        return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1])
            * static_cast<std::size_t>(size[2]);
    }
};

/// One byte per voxel, 0 or 1.
using Mask = std::vector<std::uint8_t>;

/// How many threads the filters use from now on, in the whole process; 2 unless told.
void set_filter_threads(int threads);

/// Voxels whose value lies in [low, high].
Mask threshold(std::span<const std::int16_t> values, int low, int high);

/// Euclidean distance (mm) from each voxel centre to the nearest voxel that is set, 0 in the mask. When no voxel is
/// set, everywhere the diagonal of the extent.
std::vector<float> distance_to(const Extent& extent, const Mask& mask);

/// By a ball of this radius. Outside the extent counts as unset when growing and as set when shrinking, so that a body
/// cut off by the image's border is not eaten from there.
Mask dilated(const Extent& extent, const Mask& mask, double radius_mm);
Mask eroded(const Extent& extent, const Mask& mask, double radius_mm);
Mask opened(const Extent& extent, const Mask& mask, double radius_mm);
Mask closed(const Extent& extent, const Mask& mask, double radius_mm);

/// Connected pieces (over faces), numbered from 1 by falling size; 0 elsewhere.
struct Pieces {
    std::vector<std::int32_t> piece_of; ///< per voxel
    std::vector<std::size_t> voxels; ///< per piece, [0] is piece 1
};
Pieces connected_pieces(const Extent& extent, const Mask& mask);
Mask largest_piece(const Extent& extent, const Mask& mask);
/// The pieces of `mask` that touch a voxel of `seeds`.
Mask reached_from(const Extent& extent, const Mask& mask, const Mask& seeds);

/// Sets what is enclosed in three dimensions.
Mask holes_filled(const Extent& extent, const Mask& mask);
/// Sets what is enclosed in the planes square to `axis`, one by one.
Mask holes_filled_in_planes(const Extent& extent, const Mask& mask, int axis);

/// Gaussian of standard deviation `sigma_mm`.
std::vector<std::int16_t> smoothed(const Extent& extent, std::span<const std::int16_t> values, double sigma_mm);
/// Median over a box of (2 radius_voxels + 1)^3.
std::vector<std::int16_t> median(const Extent& extent, std::span<const std::int16_t> values, int radius_voxels);

} // namespace retractor::datasets::segmentation
