#pragma once
// The hybrid model: what is cut and moved becomes tetrahedra (labels of role `wall`), everything else
// stays voxels. CGAL Mesh_3 meshes the labels with conforming interfaces, smooth where the anatomy is
// smooth, fine in a corridor round the planned incision and coarse elsewhere. Units mm, patient LPS.
//
// Meshing runs in the grid's own axes (index times spacing), with the corridor rounded to kLocalGrain,
// so that the same patient shifted or turned gives the same mesh, shifted and turned.

#include "mesh/base/job.h"
#include "mesh/generation/mesh_sizing.h"
#include "mesh/generation/mesh_statistics.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <string>

namespace retractor::mesh {

enum class MeshStatus { done, nothing_to_mesh, cancelled };

struct [[nodiscard]] HybridModel {
    MeshStatus status = MeshStatus::done;
    std::string message;
    TetMesh wall; ///< P1, labels of the LabelVolume
    MeshStatistics statistics;
};

/// @throws InputError on an empty table, a bad grid or non-positive sizes.
HybridModel build_hybrid_model(const LabelVolume& labels, const MeshSizing& sizing, const Job& job = {});

} // namespace retractor::mesh
