#pragma once
// Smooths lines that were found in voxels. Units: those of the values.

#include "mesh/base/geometry.h"

#include <vector>

namespace retractor::planner {

/// Gaussian mean over neighbours. Point reflection at the ends keeps the ends in place.
/// @pre values is not empty, and sigma_nodes is above 0
std::vector<Vec3> smoothed(const std::vector<Vec3>& values, double sigma_nodes);

/// Unit vectors along a line, from the point before to the point after. @pre at least two points
std::vector<Vec3> tangents(const std::vector<Vec3>& line);

} // namespace retractor::planner
