#pragma once
// Several masks of one world laid into one grid of labels: by the grid they choose together, nearest voxel, the smaller
// structure on top. Masks are kept as runs of voxels, so that a hundred of them fit into memory.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace retractor::datasets {

/// A stretch of voxels in memory order.
struct VoxelRun {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
};

/// The voxels of one structure in one image. A run does not pass the end of a row.
struct StructureMask {
    std::string name; ///< structures of one name are joined
    std::string source; ///< the file, for messages
    mesh::ImageGrid grid;
    std::vector<VoxelRun> runs;

    std::size_t voxel_count() const;
    double volume_mm3() const { return static_cast<double>(voxel_count()) * grid.voxel_volume(); }
};

/// The voxels of `voxels` that equal `value`.
std::vector<VoxelRun> runs_of(const mesh::ImageGrid& grid, const std::vector<Label>& voxels, Label value);

/// What an overlap took from one structure.
struct LostVoxels {
    std::size_t to = 0; ///< index of the structure that has them now
    std::size_t voxels = 0;
};

struct MergedMasks {
    mesh::ImageGrid grid;
    std::vector<Label> voxels; ///< 1 + index into names
    std::vector<std::string> names; ///< in the order in which they first occur
    std::vector<std::size_t> counts; ///< voxels each name has in the end
    std::vector<std::vector<LostVoxels>> lost; ///< per name
    bool extended = false; ///< the grid is the finest one and more
    std::string grid_source; ///< the file whose grid it is
};

/// The finest grid of all masks is kept (of equals the largest), extended by whole voxels where labelled voxels lie
/// outside it. Cancelled, it returns no voxels.
/// @throws InputError for no voxel at all, masks whose grids lie in separate places (the file in where()), and a merged
/// grid of more than 400 million voxels.
MergedMasks merge_masks(std::span<const StructureMask> masks, const Job& job = {});

} // namespace retractor::datasets
