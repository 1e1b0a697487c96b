#pragma once
// A line as a tube: vessels and nerves.

#include "mesh/base/geometry.h"

#include <vector>

namespace retractor::ui {

/// The closed surface of a tube round a line.
/// @param line mm; places that lie on each other count once
/// @returns an empty surface where the line has fewer than two places
/// @throws InputError on a radius that is not positive, or coordinates that are not finite
TriMesh tube(const std::vector<Vec3>& line, double radius_mm);

} // namespace retractor::ui
