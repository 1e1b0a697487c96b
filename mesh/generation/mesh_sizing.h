#pragma once
// What the user asks of a mesh: where the elements are fine, how large they are there and beyond, and how much of the
// wall is meshed. The size field, the statistics and the hybrid model read these options. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/image/volume.h"

#include <vector>

namespace retractor::mesh {

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

} // namespace retractor::mesh
