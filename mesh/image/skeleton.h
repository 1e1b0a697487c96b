#pragma once
// Which labels are skeleton: the one place that knows the names of hard materials.

#include "mesh/image/volume.h"

namespace retractor::mesh {

/// Bone or cartilage, whatever its role.
inline bool is_skeleton(const LabelInfo& info) { return info.material == "bone" || info.material == "cartilage"; }

} // namespace retractor::mesh
