#pragma once
// Where structures lie, plane by plane: the spine's middle and front that other organs are looked for from. Indices of
// the working grid.

#include "datasets/segmentation/image/working_image.h"

#include <limits>
#include <utility>

namespace retractor::datasets::segmentation {

/// The extents of a mask in an axial plane.
struct PlaneExtents {
    double low_y = std::numeric_limits<double>::infinity();
    double high_y = -std::numeric_limits<double>::infinity();
    double low_x = std::numeric_limits<double>::infinity();
    double high_x = -std::numeric_limits<double>::infinity();
    bool empty() const { return high_x < low_x; }
};

std::vector<PlaneExtents> plane_extents(const Extent& extent, const Mask& mask);

/// First and last plane that holds a voxel; -1 when none does.
std::pair<int, int> plane_range(const std::vector<PlaneExtents>& planes);

/// Missing values (NaN) take the nearest one, then all are averaged over +- `reach` planes.
std::vector<double> smooth_line(std::vector<double> values, int reach);

/// The front of the spine in each plane (index y) beside `middle_x`, NaN where there is none.
std::vector<double> spine_front(const Extent& extent, const Mask& spine, const std::vector<double>& middle_x);

} // namespace retractor::datasets::segmentation
