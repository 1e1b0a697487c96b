#pragma once
// What the families with badly shaped elements share.

#include "mesh/base/job.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "tests/verification/framework/stability.h"

#include <vector>

namespace retractor::verification {

/// Pulls a body along an axis that lies in every cut: the lips are free, and as nothing pulls across them the answer is
/// the linear field. Fills in residual, error, bound and condition.
/// @param lip_vertices on wounds. @param axis 0, 1 or 2. @param bound of the largest error over the largest value.
void stretch_along(StabilityRow& row, const mesh::TetMesh& mesh, const std::vector<VertexId>& lip_vertices, int axis,
    double bound, const Job& job);

} // namespace retractor::verification
