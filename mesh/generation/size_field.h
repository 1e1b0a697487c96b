#pragma once
// Wanted edge length at each point: fine in the corridor, growing with the distance, never larger than a
// label's thickness can bear. Local frame of mesh/label_field.h, mm.

#include "mesh/generation/mesh_sizing.h"
#include "mesh/image/label_field.h"

#include <vector>

namespace retractor::mesh {

/// How much the wanted edge grows per mm of distance from the corridor: neighbours then differ by about a
/// third, which refinement can follow without slivers.
inline constexpr double kEdgeGrowth = 0.4;

class SizeField {
public:
    /// @param table names the materials, which decide how many elements a label needs across.
    SizeField(
        const WallVoxels& wall, const LabelTable& table, const MeshSizing& sizing, std::vector<Vec3> local_corridor);

    /// Wanted edge length (mm) at a point in label a, or on the interface of a and b (0: none or outside).
    double edge(const Vec3& local, int a, int b = 0) const;
    /// Largest distance (mm) allowed between a surface facet and the true interface.
    double facet_distance(const Vec3& local, int a, int b) const;

private:
    double corridor_edge(const Vec3& local) const;
    double bare_factor(const Vec3& local) const;
    double thin_limit(const Vec3& local, int label) const;

    const WallVoxels& wall_;
    MeshSizing sizing_;
    std::vector<Vec3> corridor_;
    std::vector<double> edges_per_thickness_; ///< per label number
    std::vector<float> thickness_;
};

} // namespace retractor::mesh
