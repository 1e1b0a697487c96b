#pragma once
// The chest wall beyond the meshed region: drawn and looked through, not calculated. Units mm; frame patient LPS.

#include "mesh/base/job.h"
#include "mesh/generation/mesh_sizing.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

namespace retractor::planner {

/// What of the body's surface the tetrahedra do not stand for: open at the region's rim, a little under its tissue.
/// It goes along with the opened rim, and with the bones kept beyond it, and fades to rest 40 mm away (harmonic in
/// between: smooth, no mechanics). Each triangle has the label of the wall tissue just inside it.
/// @param body surface of all wall labels, see Patient::body().
/// @param displacement n x 3 (mm), one row per vertex of `wall`.
/// @returns an empty surface when the region has no limit: the tetrahedra are the whole wall then.
TriMesh unmeshed_wall_region(const TriMesh& body, const mesh::LabelVolume& labels, const mesh::MeshSizing& sizing,
    const mesh::TetMesh& wall, const Points& displacement, const Job& job = {});

} // namespace retractor::planner
