#pragma once
// The hybrid model: what is cut and moved becomes tetrahedra (labels of role `wall`), everything else
// stays voxels. CGAL Mesh_3 meshes the labels with conforming interfaces, smooth where the anatomy is
// smooth, fine in a corridor round the planned incision and coarse elsewhere. Units mm, patient LPS.
//
// Meshing runs in the grid's own axes (index times spacing), with the corridor rounded to kLocalGrain,
// so that the same patient shifted or turned gives the same mesh, shifted and turned.

#include "mesh/base/job.h"
#include "mesh/tet_mesh.h"
#include "mesh/volume.h"

#include <map>
#include <string>
#include <vector>

namespace retractor {

struct MeshSizing {
    std::vector<Vec3> corridor; ///< polyline the fine corridor follows, mm; empty: coarse everywhere
    double corridor_radius_mm = 15.0; ///< fine within this distance of the polyline ...
    double corridor_edge_mm = 3.0; ///< ... with edges of this length,
    double coarse_edge_mm = 15.0; ///< growing with the distance up to this length (thin parts stay finer)
    double region_mm = 0.0; ///< only tissue within this distance of the polyline is meshed; 0: all of it
    /// Labels whose parts that the region meets are kept to their ends, bare beyond the region, and with them what
    /// of these labels touches them: where a rib is held decides how it yields. Without a region this changes nothing.
    std::vector<Label> whole_labels;
    bool deterministic = true; ///< one thread, the same mesh on every run; false: both cores
};

struct LabelFit {
    Label label = 0;
    double voxel_volume_mm3 = 0.0; ///< of the labels inside the meshed region
    double mesh_volume_mm3 = 0.0;
    double corridor_voxel_volume_mm3 = 0.0; ///< the same inside the corridor
    double corridor_mesh_volume_mm3 = 0.0;
};

struct MeshStatistics {
    std::size_t vertices = 0, tets = 0;
    std::vector<LabelFit> fit; ///< one per wall label met
    double total_volume_error = 0.0; ///< |mesh - voxels| / voxels
    double surface_distance_mean_mm = 0.0; ///< mesh boundary to the (smoothed) label boundary
    double surface_distance_p95_mm = 0.0;
    double dihedral_worst_deg = 0.0;
    double dihedral_p01_deg = 0.0;
    int pieces = 0; ///< connected pieces of the mesh
    std::map<std::string, int>
        rib_pieces; ///< connected pieces of each rib inside the region (1: connected from end to end)
    double refine_seconds = 0.0, optimise_seconds = 0.0, total_seconds = 0.0;
    std::size_t bytes = 0;
};

enum class MeshStatus { done, nothing_to_mesh, cancelled };

struct [[nodiscard]] HybridModel {
    MeshStatus status = MeshStatus::done;
    std::string message;
    TetMesh wall; ///< P1, labels of the LabelVolume
    MeshStatistics statistics;
};

/// @throws InputError on an empty table, a bad grid or non-positive sizes.
HybridModel build_hybrid_model(const LabelVolume& labels, const MeshSizing& sizing, const Job& job = {});

} // namespace retractor
