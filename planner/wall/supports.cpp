#include "planner/wall/supports.h"
#include "mesh/base/assert.h"
#include "mesh/base/triangle.h"
#include "mesh/image/skeleton.h"
#include "planner/wall/rib_joints.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

namespace retractor::planner {

namespace {

    /// Distance outside the mesh at which the labels are read, in largest voxel edges. It exceeds the half voxel
    /// between the smooth surface and the voxels, and is much shorter than the distance to the next organ.
    constexpr double kProbeVoxels = 2.0;

    bool leaves_image(const mesh::ImageGrid& grid, const Vec3& point)
    {
        const Vec3 index = grid.index(point);
        for (int axis = 0; axis < 3; ++axis)
            if (index[axis] < -0.5 || index[axis] > grid.size[static_cast<std::size_t>(axis)] - 0.5)
                return true;
        return false;
    }

    /// Area-weighted outward normals at boundary vertices; zero at inner vertices.
    Points outward_normals(const mesh::TetMesh& mesh)
    {
        Points normals = Points::Zero(mesh.vertices.rows(), 3);
        for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
            const auto v = mesh::face_vertices(mesh, face);
            const Vec3 area = area_vector(mesh.vertices, v);
            for (const VertexId corner : v)
                normals.row(corner) += area.transpose();
        }
        return normals;
    }

    void hold_border(const mesh::TetMesh& mesh, const mesh::LabelVolume& labels, const Points& normals,
        std::span<const Label> whole_labels, bool hold_soft_tissue, std::vector<bool>& fixed)
    {
        const mesh::LabelFlags is_bone = mesh::flagged_labels(
            labels.table, [](const mesh::LabelInfo& info) { return mesh::is_wall(info) && is_skeleton(info); });
        mesh::LabelFlags is_cut_bone = is_bone;
        for (const Label label : whole_labels)
            is_cut_bone[label] = 0;
        std::vector<bool> touches_bone(mesh.vertex_count(), false), touches_whole_bone(mesh.vertex_count(), false),
            touches_cut_bone(mesh.vertex_count(), false);
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const Label label = mesh.labels[static_cast<std::size_t>(t)];
            if (is_bone[label] != 0)
                for (const VertexId v : mesh.tet(t)) {
                    touches_bone[static_cast<std::size_t>(v)] = true;
                    (is_cut_bone[label] != 0 ? touches_cut_bone : touches_whole_bone)[static_cast<std::size_t>(v)]
                        = true;
                }
        }
        const double probe_mm = kProbeVoxels * labels.grid.spacing.maxCoeff();
        const mesh::LabelFlags is_wall = mesh::flagged_labels(labels.table, mesh::is_wall);
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
            const double length = normals.row(v).norm();
            if (length == 0.0)
                continue; // interior
            const Vec3 probe = (mesh.vertices.row(v) + probe_mm / length * normals.row(v)).transpose();
            const Vec3 near_probe = (mesh.vertices.row(v) + 0.5 * probe_mm / length * normals.row(v)).transpose();
            // The end of a cartilage on a sternum that is not meshed may have a few vertices only, whose normals point
            // anywhere. So all vertices of a whole bone near the other bone are held.
            const bool ends_on_bone = touches_whole_bone[static_cast<std::size_t>(v)]
                && !touches_cut_bone[static_cast<std::size_t>(v)]
                && distance_to_labels(labels, is_cut_bone, mesh.vertices.row(v).transpose(), probe_mm) <= probe_mm;
            const bool is_held = touches_bone[static_cast<std::size_t>(v)]
                ? ends_on_bone || is_cut_bone[mesh::label_at(labels, near_probe)] != 0
                : hold_soft_tissue && is_wall[mesh::label_at(labels, probe)] != 0;
            // A bone that leaves the image hangs on its joint, or, as the shoulder girdle, in its muscles.
            const bool ends_with_image = (hold_soft_tissue || !touches_whole_bone[static_cast<std::size_t>(v)])
                && leaves_image(labels.grid, probe);
            if (is_held || ends_with_image)
                fixed[static_cast<std::size_t>(v)] = true;
        }
    }

    bool belongs_to_rib_cage(std::string_view name)
    {
        return name.starts_with("rib_") || name == "sternum" || name == "costal_cartilages";
    }

    /// Holds the vertices at the spine, without the heads of ribs, which have joints (rib_joints.h).
    /// @returns whether the spine holds anything, a rib head at least
    bool hold_spine_side(const mesh::TetMesh& mesh, const mesh::LabelVolume& labels, const Points& normals,
        std::span<const Label> fixed_labels, std::vector<bool>& fixed)
    {
        const mesh::LabelFlags wanted = mesh::flagged_labels(fixed_labels);
        const mesh::LabelFlags is_bone = mesh::flagged_labels(labels.table, mesh::is_skeleton);
        std::vector<bool> on_bone(mesh.vertex_count(), false);
        bool holds = false;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t) {
            const Label label = mesh.labels[static_cast<std::size_t>(t)];
            for (const VertexId v : mesh.tet(t)) {
                if (wanted[label] != 0)
                    fixed[static_cast<std::size_t>(v)] = holds = true;
                else if (is_bone[label] != 0)
                    on_bone[static_cast<std::size_t>(v)] = true;
            }
        }
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v)
            if (!fixed[static_cast<std::size_t>(v)] && !normals.row(v).isZero(0.0)
                && distance_to_labels(labels, wanted, mesh.vertices.row(v).transpose(), kJointGapMm) <= kJointGapMm) {
                fixed[static_cast<std::size_t>(v)] = !on_bone[static_cast<std::size_t>(v)];
                holds = true;
            }
        return holds;
    }

} // namespace

std::vector<VertexId> wall_supports(const mesh::TetMesh& mesh, const mesh::LabelVolume& labels,
    std::span<const Label> fixed_labels, std::span<const Label> whole_labels, bool region_border)
{
    std::vector<bool> fixed(mesh.vertex_count(), false);
    RETRACTOR_ASSERT(mesh.labels.size() == mesh.tet_count());
    const Points normals = outward_normals(mesh);
    const bool has_spine_side = !fixed_labels.empty() && hold_spine_side(mesh, labels, normals, fixed_labels, fixed);
    if (region_border)
        hold_border(mesh, labels, normals, whole_labels, !has_spine_side, fixed);
    std::vector<VertexId> supports;
    for (std::size_t v = 0; v < fixed.size(); ++v)
        if (fixed[v])
            supports.push_back(static_cast<VertexId>(v));
    return supports;
}

std::vector<VertexId> cut_off_vertices(const mesh::TetMesh& mesh, const mesh::LabelVolume& labels)
{
    const double probe_mm = kProbeVoxels * labels.grid.spacing.maxCoeff();
    const mesh::LabelFlags is_wall = mesh::flagged_labels(labels.table, mesh::is_wall);
    const auto goes_on = [&](const Vec3& probe) {
        return leaves_image(labels.grid, probe) || is_wall[mesh::label_at(labels, probe)] != 0;
    };
    std::vector<VertexId> vertices;
    for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
        const auto corners = mesh::face_vertices(mesh, face);
        const Vec3 out = unit_normal(mesh.vertices, corners);
        Vec3 middle = Vec3::Zero();
        for (const VertexId v : corners)
            middle += mesh.vertices.row(v).transpose() / 3.0;
        if (goes_on(middle + 0.5 * probe_mm * out) && goes_on(middle + probe_mm * out))
            vertices.insert(vertices.end(), corners.begin(), corners.end());
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    return vertices;
}

std::vector<fem::BeddedVertex> girdle_beds(
    const mesh::TetMesh& mesh, const mesh::LabelVolume& labels, std::span<const Label> whole_labels)
{
    const mesh::LabelFlags is_soft = mesh::flagged_labels(
        labels.table, [](const mesh::LabelInfo& info) { return mesh::is_wall(info) && !is_skeleton(info); });
    const mesh::LabelFlags is_whole_bone = mesh::flagged_labels(labels.table, [&](const mesh::LabelInfo& info) {
        return std::find(whole_labels.begin(), whole_labels.end(), info.id) != whole_labels.end()
            && !belongs_to_rib_cage(info.name);
    });
    std::vector<bool> only_bone(mesh.vertex_count(), true);
    RETRACTOR_ASSERT(mesh.labels.size() == mesh.tet_count());
    for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
        if (is_whole_bone[mesh.labels[static_cast<std::size_t>(t)]] == 0)
            for (const VertexId v : mesh.tet(t))
                only_bone[static_cast<std::size_t>(v)] = false;
    const Points normals = outward_normals(mesh);
    const double probe_mm = kProbeVoxels * labels.grid.spacing.maxCoeff();
    std::vector<fem::BeddedVertex> beds;
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
        const double length = normals.row(v).norm();
        if (length == 0.0 || !only_bone[static_cast<std::size_t>(v)])
            continue;
        const Vec3 probe = (mesh.vertices.row(v) + probe_mm / length * normals.row(v)).transpose();
        constexpr double kShare = 1.0 / 3.0; // share of a face's area at each corner
        if (is_soft[mesh::label_at(labels, probe)] != 0)
            beds.push_back({ static_cast<VertexId>(v), kBedModulus * kShare * length });
    }
    return beds;
}

} // namespace retractor::planner
