#pragma once
// The user's options for a mesh: edge lengths in the corridor and beyond, and the meshed part of the wall. The size
// field, the statistics and the hybrid model read these options. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"

#include <vector>

namespace retractor::mesh {

struct MeshSizing {
    std::vector<Vec3> corridor; ///< polyline along which the mesh is fine (mm); empty: coarse everywhere
    double corridor_radius_mm = 15.0; ///< distance from the polyline within which the mesh is fine
    double corridor_edge_mm = 3.0; ///< edge length in the corridor
    double coarse_edge_mm = 15.0; ///< largest edge length far from the corridor; thin parts stay finer
    /// Places round which the mesh is finer still (mm): the patches of hooks, which hold whole faces of the mesh.
    std::vector<Vec3> fine_places {};
    double fine_radius_mm = 9.0; ///< distance from these places within which edges have fine_edge_mm
    double fine_edge_mm = 3.0;
    /// Polyline along which the mesh is a little finer than far away (mm), for cuts beyond the corridor; may be empty.
    /// It begins near the corridor's last point, and may return along itself to reach places on both sides.
    std::vector<Vec3> coarse_path {};
    double coarse_path_radius_mm = 8.0; ///< distance from coarse_path within which edges have coarse_path_edge_mm
    double coarse_path_edge_mm = 7.0;
    /// Only tissue within this distance of the corridor or of coarse_path is meshed; 0: the whole wall.
    double region_mm = 0.0;
    /// Beyond this distance of the corridor and of coarse_path the wall is a coarse model: soft tissues are meshed
    /// without the interfaces between them, with edges that go on growing, and each element then gets the soft label
    /// that fills it most; 0: no coarse model. Bones keep their surfaces.
    double coarse_beyond_mm = 0.0;
    /// Labels that are meshed beyond the region: a part of such a label that meets the region is kept to its end,
    /// without the tissue round it beyond the region, together with the parts of these labels that touch it. The place
    /// where a rib is held decides how the rib yields. Without a region the list has no effect.
    std::vector<Label> whole_labels;
    /// Number of the mesh among meshes of the same sizes: the order in which the first points on the interfaces are
    /// chosen. Answers that differ between two seeds differ by chance.
    unsigned seed = 0;
    double most_tetrahedra = 0.0; ///< a mesh that is expected to have more is refused before it is made; 0: no limit
    bool deterministic = true; ///< true: one thread, the same mesh on every run; false: all cores
};

/// The polyline round which the region lies: the corridor, and then coarse_path.
inline std::vector<Vec3> region_line(const MeshSizing& sizing)
{
    std::vector<Vec3> line = sizing.corridor;
    line.insert(line.end(), sizing.coarse_path.begin(), sizing.coarse_path.end());
    return line;
}

} // namespace retractor::mesh
