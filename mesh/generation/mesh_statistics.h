#pragma once
// What a mesh of labels is worth: volumes against the voxels, distance of its surfaces from the smooth
// label boundary, dihedral angles, connectedness. Units mm.

#include "mesh/generation/mesh_sizing.h"
#include "mesh/image/label_field.h"
#include "mesh/image/volume.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace retractor::mesh {

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

/// @param mesh labels of `labels`; vertices in patient LPS. @param field the label function it was made from.
/// @param local_corridor the corridor in the field's frame.
/// Fills everything but the times.
MeshStatistics mesh_statistics(const TetMesh& mesh, const LabelVolume& labels, const LabelField& field,
    const std::vector<Vec3>& local_corridor, const MeshSizing& sizing);

} // namespace retractor::mesh
