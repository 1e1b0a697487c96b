#pragma once
// Decides which labels belong to the skeleton. No other module names the hard materials.

#include "mesh/image/volume.h"

namespace retractor::mesh {

/// True for bone and cartilage of any role.
inline bool is_skeleton(const LabelInfo& info) { return info.material == "bone" || info.material == "cartilage"; }

} // namespace retractor::mesh
