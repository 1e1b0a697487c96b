#pragma once
// What holds and moves a body: supports that stay where they are, springs on tissue that is not modelled, and hooks
// that move nodes as one. Plain data; elastic_problem.h turns these conditions into prescribed unknowns and springs.
// Units mm, N; frame patient LPS.

#include "mesh/base/geometry.h"

#include <string>
#include <vector>

namespace retractor::fem {

/// A vertex that rests on tissue which is not modelled: a spring to where it was, the same in every direction.
struct BeddedVertex {
    VertexId vertex = 0;
    double stiffness = 0.0; ///< N/mm, > 0
};

struct Supports {
    std::vector<VertexId> fixed {}; ///< held where they are
    std::vector<BeddedVertex> bedded {}; ///< each at most once
};

/// A hook: nodes moved as one, a patch of wound surface and the bone it bears on. Never a single point: point supports
/// have no limit under refinement.
struct HookPatch {
    std::string name;
    int side = 0; ///< +1 or -1: the lip it holds
    std::vector<VertexId> nodes;
    Vec3 displacement = Vec3::Zero(); ///< mm, prescribed for all nodes
};

} // namespace retractor::fem
