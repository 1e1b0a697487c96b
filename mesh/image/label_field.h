#pragma once
// Voxel labels as a smooth function of position. The indicator of each label is interpolated with cubic B-splines,
// which smooth by half a voxel; the label of a point is the label with the largest value. Surfaces come out smooth
// instead of as stairs, and a layer one voxel thin keeps its volume. Units mm. "Local" means the grid's own frame,
// index times spacing, for any direction of the grid's axes.

#include "mesh/base/corridor.h"
#include "mesh/image/volume.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace retractor::mesh {

/// Corridor points are rounded to this grain (mm) in the local frame, and voxel edges to kEdgeGrain (mm). Both grains
/// are far above round-off, so that a shifted or turned patient, read from any kind of file, gives bit-equal numbers.
/// The grain is no round number, because planned coordinates often are round and must not fall between two grains.
inline constexpr double kLocalGrain = 0.0113701;
inline constexpr double kEdgeGrain = 1e-8;

/// Local coordinates (mm) of world points, rounded to kLocalGrain.
std::vector<Vec3> local_points(const ImageGrid& grid, std::span<const Vec3> world);
/// World position (mm, LPS) of a local point.
Vec3 world_point(const ImageGrid& grid, const Vec3& local);

/// The crop of the image that meshing uses: wall labels within the region, with a border of "outside". Labels are
/// renumbered: 0 is outside, 1 + i stands for labels[i].
struct WallVoxels {
    std::array<int, 3> size { 0, 0, 0 }; ///< voxels of the crop
    std::array<int, 3> first { 0, 0, 0 }; ///< index of the crop's voxel (0,0,0) in the whole grid
    Vec3 spacing = Vec3::Ones(); ///< mm
    std::vector<std::uint8_t> voxels;
    std::vector<Label> labels; ///< wall labels that occur in the crop, in the table's order
    std::vector<char> whole; ///< per entry of `labels`: 1 when the label is kept beyond the region

    std::size_t offset(int i, int j, int k) const
    {
        return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j))
            * static_cast<std::size_t>(size[0])
            + static_cast<std::size_t>(i);
    }
    /// Local position (mm) of the centre of a voxel of the crop.
    Vec3 centre(int i, int j, int k) const
    {
        return spacing.cwiseProduct(Vec3(i + first[0], j + first[1], k + first[2]));
    }
    bool empty() const { return labels.empty(); }
};

/// Limits of the wall to be meshed, in the local frame.
struct Region {
    std::vector<Vec3> corridor; ///< polyline, local points (mm)
    double region_mm = 0.0; ///< largest distance from the corridor (mm); 0: no limit
    std::vector<Label> whole_labels; ///< MeshSizing::whole_labels
    /// Beyond this distance from the corridor (mm) all of `merged_labels` count as one label; 0: nowhere.
    double merge_beyond_mm = 0.0;
    std::vector<Label> merged_labels {};
};

/// Crops and renumbers the labels that meshing uses.
/// @throws InputError when more than 254 wall labels occur, or when the table misses a voxel's label
WallVoxels wall_voxels(const LabelVolume& labels, const Region& region);

class LabelField {
public:
    /// Points beyond the region are outside, except points of labels that are kept whole.
    LabelField(WallVoxels wall, Region region);

    /// Number of the label at a local point (mm): 0 outside, 1 + i for wall().labels[i]. Thread-safe.
    int at(const Vec3& local) const;
    /// The same without merging labels (Region::merge_beyond_mm).
    int unmerged_at(const Vec3& local) const;
    /// The number that at() gives at a local point where the voxels have this number: beyond Region::merge_beyond_mm,
    /// merged_number() for labels that merge.
    int merged(int number, const Vec3& local) const;
    /// Whether labels merge at this place.
    bool merges_at(const Vec3& local) const;
    bool merges(int number) const { return !merges_.empty() && merges_[static_cast<std::size_t>(number)] != 0; }
    /// The number of the merged label with most voxels; 0 without any.
    int merged_number() const { return merged_; }
    /// The point between a and b where the number changes, within `tolerance` mm, on the side of `a`.
    Vec3 crossing(Vec3 a, Vec3 b, double tolerance) const;

    const WallVoxels& wall() const { return wall_; }
    /// Corners of the box that holds the body with a margin, local mm.
    Vec3 lower() const { return wall_.centre(0, 0, 0); }
    Vec3 upper() const { return wall_.centre(wall_.size[0] - 1, wall_.size[1] - 1, wall_.size[2] - 1); }

private:
    int smooth_at(const std::array<int, 3>& cell, const Vec3& fraction) const;
    void choose_merged_label();

    WallVoxels wall_;
    Region region_;
    CorridorDistance corridor_;
    std::vector<char> merges_; ///< per label number: 1 for merged labels; empty: nothing is merged
    int merged_ = 0; ///< number of the merged label with most voxels
    std::vector<std::uint8_t> uniform_; ///< per cell: common label of the 4x4x4 voxels round the cell, or kMixed
};

} // namespace retractor::mesh
