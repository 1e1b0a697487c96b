#pragma once
// Measures the quality of a mesh of labels: volumes against the voxels, distance of the mesh's surfaces from the smooth
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
    double voxel_volume_mm3 = 0.0; ///< volume of the label's voxels in the meshed region
    double mesh_volume_mm3 = 0.0; ///< volume of the label's elements
    double corridor_voxel_volume_mm3 = 0.0; ///< voxel volume inside the corridor
    double corridor_mesh_volume_mm3 = 0.0; ///< mesh volume inside the corridor
};

struct MeshStatistics {
    std::size_t vertices = 0, tets = 0;
    /// One per wall label in the mesh. In a coarse model (MeshSizing::coarse_beyond_mm) only the sum over the soft
    /// labels is fitted.
    std::vector<LabelFit> fit;
    double total_volume_error = 0.0; ///< |mesh - voxels| / voxels
    double surface_distance_mean_mm = 0.0; ///< mean distance of the mesh boundary from the smoothed label boundary
    double surface_distance_p95_mm = 0.0; ///< 95th percentile of the same distance
    double dihedral_worst_deg = 0.0; ///< smallest dihedral angle
    double dihedral_p01_deg = 0.0; ///< 1st percentile of the dihedral angles
    int pieces = 0; ///< connected pieces of the mesh
    /// Connected pieces of each rib inside the region, by name; 1 means connected from end to end.
    std::map<std::string, int> rib_pieces;
    double refine_seconds = 0.0, optimise_seconds = 0.0, total_seconds = 0.0;
    std::size_t bytes = 0;
};

/// The polylines of the sizing in the field's frame.
struct LocalLines {
    std::vector<Vec3> corridor;
    std::vector<Vec3> region; ///< region_line()
};

/// Computes all statistics except the times.
/// @param mesh labels of `labels`; vertices in patient LPS
/// @param field label function that the mesh was made from
MeshStatistics mesh_statistics(const TetMesh& mesh, const LabelVolume& labels, const LabelField& field,
    const LocalLines& lines, const MeshSizing& sizing);

} // namespace retractor::mesh
