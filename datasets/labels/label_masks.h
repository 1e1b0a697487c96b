#pragma once
// Merges several masks of one world frame into one grid of labels. The merge chooses the grid, resamples by the nearest
// voxel, and lets the smaller structure win an overlap. Masks are stored as runs of voxels, so that a hundred masks fit
// into memory.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace retractor::datasets {

/// Consecutive voxels in memory order.
struct VoxelRun {
    std::uint32_t first = 0; ///< offset of the first voxel
    std::uint32_t count = 0; ///< number of voxels
};

/// The voxels of one structure in one image. No run passes the end of a row.
struct StructureMask {
    std::string name; ///< structures with the same name are joined
    std::string source; ///< the file, for messages
    mesh::ImageGrid grid;
    std::vector<VoxelRun> runs; ///< in memory order

    std::size_t voxel_count() const;
    double volume_mm3() const { return static_cast<double>(voxel_count()) * grid.voxel_volume(); }
};

/// The runs of all voxels in `voxels` with this value.
std::vector<VoxelRun> runs_of(const mesh::ImageGrid& grid, const std::vector<Label>& voxels, Label value);

/// The voxels that one structure lost to another in an overlap.
struct LostVoxels {
    std::size_t to = 0; ///< index of the structure that has the voxels now
    std::size_t voxels = 0; ///< number of lost voxels
};

/// The merged labels, and a record of the overlaps.
struct MergedMasks {
    mesh::ImageGrid grid;
    std::vector<Label> voxels; ///< 1 + index in `names`; 0 without a structure
    std::vector<std::string> names; ///< in the order of their first masks
    std::vector<std::size_t> counts; ///< voxels of each name in the result
    std::vector<std::vector<LostVoxels>> lost; ///< one list per name
    bool extended = false; ///< the grid is larger than the finest grid
    std::string grid_source; ///< the file with the finest grid
};

/// Merges masks on the finest of their grids, or the largest of equally fine grids. Whole voxels extend the grid where
/// labelled voxels lie outside. A cancelled merge returns no voxels.
/// @throws InputError when no mask has a voxel, when the grids of masks lie apart (the file in where()), and when the
/// merged grid has more than 400 million voxels.
MergedMasks merge_masks(std::span<const StructureMask> masks, const Job& job = {});

} // namespace retractor::datasets
