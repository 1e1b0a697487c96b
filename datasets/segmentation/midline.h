#pragma once
// Positions of structures in each axial plane, such as the front of the spine. The searches for other organs start from
// these positions. Indices of the working grid.

#include "datasets/segmentation/image/working_image.h"

#include <limits>
#include <utility>

namespace retractor::datasets::segmentation {

/// The bounds of a mask in an axial plane, as indices.
struct PlaneExtents {
    double low_y = std::numeric_limits<double>::infinity();
    double high_y = -std::numeric_limits<double>::infinity();
    double low_x = std::numeric_limits<double>::infinity();
    double high_x = -std::numeric_limits<double>::infinity();
    bool empty() const { return high_x < low_x; }
};

/// The bounds of a mask in every axial plane.
std::vector<PlaneExtents> plane_extents(const Extent& extent, const Mask& mask);

/// First and last plane with a set voxel; -1 and -1 for an empty mask.
std::pair<int, int> plane_range(const std::vector<PlaneExtents>& planes);

/// Replaces missing values (NaN) by the nearest value, then averages over +- `reach` planes.
std::vector<double> smooth_line(std::vector<double> values, int reach);

/// The front of the spine in each plane (index y), near the column `middle_x`; NaN in planes without spine.
std::vector<double> spine_front(const Extent& extent, const Mask& spine, const std::vector<double>& middle_x);

} // namespace retractor::datasets::segmentation
