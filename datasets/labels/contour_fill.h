#pragma once
// Fills closed contours on a grid.

#include "mesh/image/volume.h"

#include <cstdint>
#include <vector>

namespace retractor::datasets {

/// A closed polygon in a plane of the grid, mm; the last point is joined to the first.
struct Contour {
    std::vector<Vec3> points;
};

/// Changes the voxels whose centres lie inside the contour: outside becomes inside and inside becomes outside, so that
/// a contour within a contour is a hole.
/// @param voxels one per voxel of the grid
/// @pre the contour lies in a plane of constant k of the grid, to half a plane; the grid's size fits the voxels
void fill_contour(const mesh::ImageGrid& grid, const Contour& contour, std::vector<std::uint8_t>& voxels);

} // namespace retractor::datasets
