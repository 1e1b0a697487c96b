#pragma once
// Thickness of each label at each of its voxels: thin layers and ribs need smaller elements than their surroundings. A
// distance transform is computed inside each label; every voxel then climbs to its nearest ridge and takes twice the
// distance found there. Units mm.

#include "mesh/image/label_field.h"

#include <vector>

namespace retractor::mesh {

/// Thickness (mm) of the label at each voxel. Voxels outside have 0.
std::vector<float> local_thickness(const WallVoxels& wall);

} // namespace retractor::mesh
