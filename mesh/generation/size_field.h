#pragma once
// Wanted edge length at each point: fine in the corridor and growing with the distance, with an upper limit from the
// label's thickness. Local frame of mesh/image/label_field.h, mm.

#include "mesh/base/corridor.h"
#include "mesh/generation/mesh_sizing.h"
#include "mesh/image/label_field.h"

#include <vector>

namespace retractor::mesh {

class SizeField {
public:
    /// @param table names the materials; a label's material decides the number of elements across the label
    /// @param local_places MeshSizing::fine_places in the local frame
    /// @param local_path MeshSizing::coarse_path in the local frame
    SizeField(const WallVoxels& wall, const LabelTable& table, const MeshSizing& sizing,
        std::vector<Vec3> local_corridor, std::vector<Vec3> local_places = {}, std::vector<Vec3> local_path = {});

    /// Wanted edge length (mm) at a local point in label a, or on the interface of labels a and b. A label number 0
    /// means outside or no second label.
    double edge(const Vec3& local, int a, int b = 0) const;
    /// Largest allowed distance (mm) between a surface facet and the true interface.
    double facet_distance(const Vec3& local, int a, int b) const;

private:
    double corridor_edge(const Vec3& local, double into_coarse_mm) const;
    double path_edge(const Vec3& local) const;
    double fine_edge(const Vec3& local) const;
    /// Distance from the border of the coarse model (MeshSizing::coarse_beyond_mm), mm; 0 outside the model.
    double into_coarse(const Vec3& local) const;
    double bare_factor(const Vec3& local) const;
    double thin_limit(const Vec3& local, int label) const;

    const WallVoxels& wall_;
    MeshSizing sizing_;
    CorridorDistance corridor_, path_;
    CorridorDistance region_line_; ///< region_line() in the local frame
    std::vector<Vec3> places_;
    std::vector<double> edges_per_thickness_; ///< largest edge length over thickness, per label number
    std::vector<char> is_bone_; ///< per entry of WallVoxels::labels
    std::vector<float> thickness_;
};

} // namespace retractor::mesh
