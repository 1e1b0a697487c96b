#pragma once
// How thick each label is, at each of its voxels: thin layers and ribs need smaller elements than their
// surroundings. Distance transform inside each label, then every voxel climbs to its nearest ridge and
// takes twice the distance found there. Units mm.

#include "mesh/image/label_field.h"

#include <vector>

namespace retractor::mesh {

/// Distance (mm) from each voxel's centre to the nearest face between it and another label, along the
/// centres of voxels (exact for flat faces along the axes). 0 where the voxel is outside.
std::vector<float> depth_in_label(const WallVoxels& wall);

/// Thickness (mm) of the label at each voxel. 0 where the voxel is outside.
std::vector<float> local_thickness(const WallVoxels& wall);

} // namespace retractor::mesh
