#pragma once
// Boundary conditions of a body: fixed supports, springs in place of tissue that is not modelled, hinges of bones, and
// hooks that move their nodes together. Plain data; elastic_problem.h turns these conditions into prescribed unknowns
// and springs. Units mm, N; frame patient LPS.

#include "fem/model/hinge.h"
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
    std::vector<Hinge> hinges {}; ///< torques against the turn of bones that rest on such springs
};

/// A hook: nodes that move together, a patch of wound surface with the bone under the patch. A hook is never a single
/// point, since point supports have no limit under refinement. The blade of a retractor also turns (blade_frame.h).
struct HookPatch {
    std::string name;
    int side = 0; ///< +1 or -1: the lip that the hook holds
    std::vector<VertexId> nodes;
    /// mm, prescribed for all nodes; where the hook turns, the displacement of its pivot
    Vec3 displacement = Vec3::Zero();
    Mat3 rotation = Mat3::Identity(); ///< turn of the hook about its pivot, a proper rotation
    Vec3 pivot = Vec3::Zero(); ///< place of the pivot at rest, mm

    bool turns() const { return rotation != Mat3::Identity(); }

    /// The prescribed displacement of a node, mm. @param at_rest place of the node at rest, mm
    Vec3 displacement_of(const Vec3& at_rest) const
    {
        if (!turns()) // to the last bit, since hooks that share nodes must agree
            return displacement;
        return displacement + rotation * (at_rest - pivot) - (at_rest - pivot);
    }
};

} // namespace retractor::fem
