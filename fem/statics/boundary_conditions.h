#pragma once
// Boundary conditions of a body: fixed supports, springs in place of tissue that is not modelled, and hooks that move
// their nodes together. Plain data; elastic_problem.h turns these conditions into prescribed unknowns and springs.
// Units mm, N; frame patient LPS.

#include "mesh/base/geometry.h"

#include <string>
#include <vector>

namespace retractor::fem {

/// A vertex on a bed of tissue that is not modelled. A spring, equally stiff in every direction, pulls the vertex to
/// its position at rest.
struct BeddedVertex {
    VertexId vertex = 0;
    double stiffness = 0.0; ///< N/mm, > 0
};

struct Supports {
    std::vector<VertexId> fixed {}; ///< vertices that do not move
    std::vector<BeddedVertex> bedded {}; ///< vertices on springs; each vertex at most once
};

/// A hook: nodes that move together, a patch of wound surface with the bone under the patch. A hook is never a single
/// point, since point supports have no limit under refinement.
struct HookPatch {
    std::string name;
    int side = 0; ///< +1 or -1: the lip that the hook holds
    std::vector<VertexId> nodes;
    Vec3 displacement = Vec3::Zero(); ///< mm, prescribed for all nodes
};

} // namespace retractor::fem
