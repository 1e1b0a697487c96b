#pragma once
// Builds the hybrid model: labels of role `wall`, which are cut and moved, become tetrahedra; all other labels stay
// voxels. CGAL Mesh_3 meshes the labels with conforming interfaces, smooth where the anatomy is smooth, fine in a
// corridor round the planned incision and coarse elsewhere. Units mm; frame patient LPS.
//
// Meshing runs in the grid's own axes (index times spacing), with the corridor rounded to kLocalGrain. A patient who is
// shifted or turned therefore gives the same mesh, shifted or turned.

#include "mesh/base/job.h"
#include "mesh/generation/mesh_sizing.h"
#include "mesh/generation/mesh_statistics.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <functional>
#include <string>

namespace retractor::mesh {

enum class MeshStatus { done, nothing_to_mesh, cancelled };

struct [[nodiscard]] HybridModel {
    MeshStatus status = MeshStatus::done;
    std::string message; ///< remarks for the user; may be empty
    TetMesh wall; ///< P1, labels of the LabelVolume
    MeshStatistics statistics;
    double expected_tetrahedra = 0.0; ///< forecast, made before meshing
};

/// Meshes the wall of a label image.
/// @param on_forecast called with the expected number of tetrahedra before they are made; may throw to refuse them
/// @throws InputError on an empty table, a bad grid or sizes that are not positive, and where more
/// tetrahedra are expected than MeshSizing::most_tetrahedra allows
HybridModel build_hybrid_model(const LabelVolume& labels, const MeshSizing& sizing, const Job& job = {},
    const std::function<void(double expected)>& on_forecast = {});

} // namespace retractor::mesh
