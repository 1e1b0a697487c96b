#pragma once
// Thickness of each label at each of its voxels: thin layers and ribs need smaller elements than their surroundings. A
// distance transform is computed inside each label; every voxel then climbs to its nearest ridge and takes twice the
// distance found there. Units mm.

#include "mesh/image/label_field.h"

#include <vector>

namespace retractor::mesh {

/// Distance (mm) from each voxel's centre to the nearest face between the voxel's label and another label, measured
/// along the centres of voxels (exact for flat faces along the axes). Voxels outside have 0.
std::vector<float> depth_in_label(const WallVoxels& wall);

/// Thickness (mm) of the label at each voxel. Voxels outside have 0.
std::vector<float> local_thickness(const WallVoxels& wall);

} // namespace retractor::mesh
