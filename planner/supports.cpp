#include "planner/supports.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>

namespace retractor {

namespace {

    /// How far outside the mesh the labels are asked, in largest voxel edges: past the half voxel that the
    /// smooth mesh surface may stand off the voxel one, and well short of the next organ.
    constexpr double kProbeVoxels = 2.0;

    bool is_cut_off(const LabelVolume& labels, const std::vector<bool>& is_wall, const Vec3& probe)
    {
        const Vec3 index = labels.grid.index(probe);
        for (int axis = 0; axis < 3; ++axis)
            if (index[axis] < -0.5 || index[axis] > labels.grid.size[static_cast<std::size_t>(axis)] - 0.5)
                return true;
        return is_wall[label_at(labels, probe)];
    }

    std::vector<bool> wall_flags(const LabelTable& table)
    {
        std::vector<bool> is_wall(static_cast<std::size_t>(std::numeric_limits<Label>::max()) + 1, false);
        for (const LabelInfo& info : table)
            is_wall[info.id] = info.role == Role::wall;
        return is_wall;
    }

    /// Area-weighted outward normals at boundary vertices; zero inside.
    Points outward_normals(const TetMesh& mesh)
    {
        Points normals = Points::Zero(mesh.vertices.rows(), 3);
        for (const TetFace& face : boundary_faces(mesh)) {
            const auto v = face_vertices(mesh, face);
            const Vec3 a = mesh.vertices.row(v[0]);
            const Vec3 b = mesh.vertices.row(v[1]);
            const Vec3 c = mesh.vertices.row(v[2]);
            const Vec3 area = (b - a).cross(c - a);
            for (const VertexId corner : v)
                normals.row(corner) += area.transpose();
        }
        return normals;
    }

    void hold_border(const TetMesh& mesh, const LabelVolume& labels, std::vector<bool>& fixed)
    {
        const Points normals = outward_normals(mesh);
        const double probe_mm = kProbeVoxels * labels.grid.spacing.maxCoeff();
        const std::vector<bool> is_wall = wall_flags(labels.table);
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
            const double length = normals.row(v).norm();
            if (length == 0.0)
                continue; // interior
            const Vec3 probe = (mesh.vertices.row(v) + probe_mm / length * normals.row(v)).transpose();
            if (is_cut_off(labels, is_wall, probe))
                fixed[static_cast<std::size_t>(v)] = true;
        }
    }

} // namespace

std::vector<VertexId> wall_supports(
    const TetMesh& mesh, const LabelVolume& labels, std::span<const Label> fixed_labels, bool region_border)
{
    std::vector<bool> fixed(mesh.vertex_count(), false);
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        if (std::find(fixed_labels.begin(), fixed_labels.end(), mesh.labels[static_cast<std::size_t>(t)])
            != fixed_labels.end())
            for (const VertexId v : mesh.tet(t))
                fixed[static_cast<std::size_t>(v)] = true;
    if (region_border)
        hold_border(mesh, labels, fixed);
    std::vector<VertexId> supports;
    for (std::size_t v = 0; v < fixed.size(); ++v)
        if (fixed[v])
            supports.push_back(static_cast<VertexId>(v));
    return supports;
}

} // namespace retractor
