#pragma once
// A hook that holds a wound open while it is cut. Units mm, N.

#include "fem/statics/hook_drive.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdint>
#include <string>
#include <vector>

namespace retractor::fem {

/// Vertices that move as one: a patch, or all that a stiff bar takes. Never a single point.
struct OnlineHook {
    std::string name;
    int side = 0; ///< +1 or -1: the lip it holds; for sums
    std::vector<VertexId> nodes; ///< at least three
    HookDrive drive;
};
using HookId = int; ///< stays the same while others come and go

/// A vertex that moves with a hook.
struct HeldVertex {
    VertexId vertex = 0;
    std::int32_t hook = 0; ///< its number among the attached
};

} // namespace retractor::fem
