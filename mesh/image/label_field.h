#pragma once
// Voxel labels as a smooth function of position: each label's indicator is interpolated with cubic
// B-splines (a small smoothing: half a voxel) and the label of a point is the one with the largest value.
// Surfaces come out smooth instead of as stairs, and a layer one voxel thin keeps its volume.
// Frame: the grid's own, index times spacing, in mm, whatever the direction of the axes: "local".

#include "mesh/base/corridor.h"
#include "mesh/image/volume.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace retractor::mesh {

/// Corridor points are rounded to this (mm) after their transformation into the local frame, and voxel edges to
/// kEdgeGrain, both far above round-off, so that a shifted or turned patient, read from any kind of file, gives
/// bit-equal numbers. An odd number: planned coordinates stand at round ones, and must not fall between two grains.
inline constexpr double kLocalGrain = 0.0113701;
inline constexpr double kEdgeGrain = 1e-8;

/// Local coordinates (mm) of world points, rounded to kLocalGrain.
std::vector<Vec3> local_points(const ImageGrid& grid, std::span<const Vec3> world);
/// World position (mm, LPS) of a local point.
Vec3 world_point(const ImageGrid& grid, const Vec3& local);

/// The part of the voxels that matters (wall labels within the region, plus a border of "outside"), with
/// labels renumbered: 0 outside, then 1 + position in `labels`.
struct WallVoxels {
    std::array<int, 3> size { 0, 0, 0 }; ///< of the crop
    std::array<int, 3> first { 0, 0, 0 }; ///< index of the crop's voxel (0,0,0) in the whole grid
    Vec3 spacing = Vec3::Ones();
    std::vector<std::uint8_t> voxels;
    std::vector<Label> labels; ///< wall labels that occur in the crop, in the table's order
    std::vector<char> whole; ///< per entry of `labels`: kept beyond the region too

    std::size_t offset(int i, int j, int k) const
    {
        return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j))
            * static_cast<std::size_t>(size[0])
            + static_cast<std::size_t>(i);
    }
    /// Local position of the centre of a voxel of the crop.
    Vec3 centre(int i, int j, int k) const
    {
        return spacing.cwiseProduct(Vec3(i + first[0], j + first[1], k + first[2]));
    }
    bool empty() const { return labels.empty(); }
};

/// The limits of the wall to be meshed, in the local frame.
struct Region {
    std::vector<Vec3> corridor; ///< local points
    double region_mm = 0.0; ///< 0: no limit
    std::vector<Label> whole_labels; ///< see MeshSizing
};

/// @throws InputError when more than 254 wall labels occur, or a voxel has a label that is not in the table.
WallVoxels wall_voxels(const LabelVolume& labels, const Region& region);

class LabelField {
public:
    /// Points beyond the region are outside, unless their label is kept whole.
    LabelField(WallVoxels wall, Region region);

    /// Number of the label at a local point: 0 outside, otherwise 1 + position in wall().labels. Thread-safe.
    int at(const Vec3& local) const;
    /// The point where the number changes between a and b, to `tolerance` mm, on the side of `a`.
    Vec3 crossing(Vec3 a, Vec3 b, double tolerance) const;

    const WallVoxels& wall() const { return wall_; }
    /// Box that holds the body with a margin, local mm.
    Vec3 lower() const { return wall_.centre(0, 0, 0); }
    Vec3 upper() const { return wall_.centre(wall_.size[0] - 1, wall_.size[1] - 1, wall_.size[2] - 1); }

private:
    int smooth_at(const std::array<int, 3>& cell, const Vec3& fraction) const;

    WallVoxels wall_;
    Region region_;
    CorridorDistance corridor_;
    std::vector<std::uint8_t> uniform_; ///< per cell: the label all 4x4x4 voxels round it share, or kMixed
};

} // namespace retractor::mesh
