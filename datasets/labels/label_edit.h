#pragma once
// Corrects labels voxel by voxel: paint, erase, fill, smooth, drop islands, interpolate between slices, join. Every
// edit is a list of voxels with their labels before and after, so that it can be taken back. Units mm; frame patient
// LPS.

#include "mesh/image/volume.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace retractor::datasets {

/// A change of labels. Each voxel occurs once.
struct LabelEdit {
    std::string what; ///< the edit in words, for "Undo"
    std::vector<std::size_t> voxels; ///< offsets of the voxels that change
    std::vector<Label> before, after; ///< one per voxel
    bool empty() const { return voxels.empty(); }
};

/// @pre the labels are as they were when the edit was made
void make_edit(mesh::LabelVolume& labels, const LabelEdit& edit);
/// Gives the voxels their labels from before the edit. @pre make_edit() was called
void take_back(mesh::LabelVolume& labels, const LabelEdit& edit);

/// The way of a brush. Without a normal the brush is a ball; with one it is a disc in the slice in which the path lies,
/// as thick as a voxel.
struct BrushStroke {
    std::vector<Vec3> path; ///< at least one place; straight between places
    double radius_mm = 0.0;
    std::optional<Vec3> normal {}; ///< unit
};

/// The voxels whose centres the brush meets, in memory order. The voxel under a place counts even where the brush is
/// smaller than a voxel.
/// @throws InputError on an empty path, a radius that is not above 0, NaN, or a disc's path through several slices
std::vector<std::size_t> voxels_under(const mesh::ImageGrid& grid, const BrushStroke& stroke);

/// Gives voxels the label `with`; labels flagged in `kept` stay.
LabelEdit painted(const mesh::LabelVolume& labels, const BrushStroke& stroke, Label with, const mesh::LabelFlags& kept);
/// Takes a label away. Its voxels get the label of the nearest other voxel; deep inside the label, none.
LabelEdit erased(const mesh::LabelVolume& labels, const BrushStroke& stroke, Label label);
/// Gives the connected region of equal labels round a place, in one slice, another label.
/// @param normal unit, across the slice
/// @throws InputError when the place lies outside the image
LabelEdit region_filled(const mesh::LabelVolume& labels, const Vec3& place, const Vec3& normal, Label with);
/// Smooths the surface of a label: a voxel has the label where most of the box of 2 `radius_voxels` + 1 voxels a side
/// round it has. Labels flagged in `kept` lose nothing.
LabelEdit smoothed(const mesh::LabelVolume& labels, Label label, int radius_voxels, const mesh::LabelFlags& kept);
/// Keeps the largest piece of a label, connected over faces; the other pieces get the labels around them.
LabelEdit without_islands(const mesh::LabelVolume& labels, Label label);
/// Fills the slices between those that hold the label, by interpolation of the signed distances from its outlines
/// (Raya, Udupa 1990, IEEE TMI 9:32). Labels flagged in `kept` stay.
/// @param axis of the grid, 0 to 2, across the slices
LabelEdit interpolated(const mesh::LabelVolume& labels, Label label, int axis, const mesh::LabelFlags& kept);
/// Gives all voxels of one label another.
LabelEdit joined(const mesh::LabelVolume& labels, Label from, Label to);

/// The grid's axis that is nearest to a direction.
int nearest_axis(const mesh::ImageGrid& grid, const Vec3& direction);

} // namespace retractor::datasets
