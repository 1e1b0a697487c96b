#pragma once
// Common parts of the families with badly shaped elements.

#include "mesh/base/job.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "tests/verification/framework/stability.h"

#include <vector>

namespace retractor::verification {

/// Pulls a body along an axis that lies in the plane of every cut. The lips are free and nothing pulls across them,
/// so the answer is the linear field. Fills in residual, error, bound and condition.
/// @param lip_vertices vertices on wounds.
/// @param axis 0, 1 or 2.
/// @param bound largest error over the largest value that passes.
void stretch_along(StabilityRow& row, const mesh::TetMesh& mesh, const std::vector<VertexId>& lip_vertices, int axis,
    double bound, const Job& job);

} // namespace retractor::verification
