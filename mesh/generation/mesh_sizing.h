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
    double region_mm = 0.0; ///< only tissue within this distance of the polyline is meshed; 0: the whole wall
    /// Labels that are meshed beyond the region: a part of such a label that meets the region is kept to its end,
    /// without the tissue round it beyond the region, together with the parts of these labels that touch it. The place
    /// where a rib is held decides how the rib yields. Without a region the list has no effect.
    std::vector<Label> whole_labels;
    bool deterministic = true; ///< true: one thread, the same mesh on every run; false: all cores
};

} // namespace retractor::mesh
