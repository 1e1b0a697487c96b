#pragma once
// A hook that holds a wound open while the body is cut. Units mm, N.

#include "fem/statics/hook_drive.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdint>
#include <string>
#include <vector>

namespace retractor::fem {

/// Vertices that move together: a patch of the lip, or the whole grasp of a stiff bar. A hook is never a single point.
struct OnlineHook {
    std::string name;
    int side = 0; ///< +1 or -1: the lip that the hook holds; for sums over a lip
    std::vector<VertexId> nodes; ///< at least three
    HookDrive drive;
};
using HookId = int; ///< stays the same when other hooks are attached or detached

/// A vertex that moves with a hook.
struct HeldVertex {
    VertexId vertex = 0;
    std::int32_t hook = 0; ///< index of the hook among the attached hooks
};

} // namespace retractor::fem
