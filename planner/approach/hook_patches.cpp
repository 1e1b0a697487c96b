#include "planner/approach/hook_patches.h"

#include "fem/statics/hook.h"
#include "mesh/base/error.h"
#include "mesh/base/triangle.h"
#include "mesh/surface/proximity.h"
#include "planner/approach/bearing_points.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <set>

namespace retractor::planner {

namespace {

    /// Whether a vertex lies in the tissue behind a lip, or on it. A point of bone a fraction of a millimetre behind
    /// the planned cut lies before a lip that was cut by hand a millimetre away, in the tissue of the other lip: a hook
    /// that held it would pull the two lips through each other.
    bool lies_behind(const mesh::TetMesh& wall, std::span<const std::array<VertexId, 3>> lip, VertexId vertex)
    {
        constexpr double kOnLipMm = 1e-6; // far above the round-off of positions, far below any element
        const Vec3 at = point_at(wall.vertices, vertex);
        double nearest = std::numeric_limits<double>::infinity();
        Vec3 foot = Vec3::Zero(), area = Vec3::Zero(); // at an edge or a corner all its faces count
        for (const std::array<VertexId, 3>& face : lip) {
            const std::array corners { point_at(wall.vertices, face[0]), point_at(wall.vertices, face[1]),
                point_at(wall.vertices, face[2]) };
            const mesh::ClosestPoint closest = mesh::closest_on_triangle(at, corners[0], corners[1], corners[2]);
            if (closest.distance > nearest + kOnLipMm)
                continue;
            if (closest.distance < nearest - kOnLipMm)
                area.setZero();
            nearest = std::min(nearest, closest.distance);
            area += area_vector(wall.vertices, face);
            foot = closest.barycentric[0] * corners[0] + closest.barycentric[1] * corners[1]
                + closest.barycentric[2] * corners[2];
        }
        const double before = area.normalized().dot(at - foot); // a zero area stays zero
        return before <= kOnLipMm;
    }

} // namespace

std::vector<fem::HookPatch> hook_patches(const mesh::TetMesh& wall, std::span<const mesh::LipFace> lips,
    const Approach& approach, const mesh::LabelTable& table, const fem::Supports& supports)
{
    std::map<int, std::vector<std::array<VertexId, 3>>> lip_of_side;
    std::map<int, std::set<VertexId>> vertices_of_side;
    for (const mesh::LipFace& lip : lips) {
        lip_of_side[lip.side].push_back(mesh::face_vertices(wall, lip.face));
        vertices_of_side[lip.side].insert(lip_of_side[lip.side].back().begin(), lip_of_side[lip.side].back().end());
    }
    const std::set<VertexId> held(supports.fixed.begin(), supports.fixed.end());
    std::vector<fem::HookPatch> patches;
    for (const HookSpec& spec : approach.hooks) {
        const PatchPlace place = patch_place(approach, spec);
        const std::vector<VertexId> on_lip = fem::hook_patch_nodes(wall, lip_of_side[spec.side], place.centre,
            place.along, place.depth, spec.patch_width_mm, spec.patch_height_mm, spec.name);
        std::set<VertexId> nodes(on_lip.begin(), on_lip.end());
        for (const VertexId v : bearing_vertices(wall, table, spec))
            if (lies_behind(wall, lip_of_side[spec.side], v))
                nodes.insert(v);
        // Where the cut ends inside the tissue, both lips share their vertices. No hook can hold these vertices.
        const std::set<VertexId>& other_lip = vertices_of_side[-spec.side];
        std::erase_if(nodes, [&](VertexId v) { return other_lip.contains(v) || held.contains(v); });
        if (nodes.size() < 3)
            throw InputError(
                "fewer than three free nodes lie under the patch: a hook is never a point", "hook '" + spec.name + "'");
        patches.push_back({ .name = spec.name,
            .side = spec.side,
            .nodes = { nodes.begin(), nodes.end() },
            .displacement = spec.opening_mm * spec.direction });
    }
    return patches;
}

std::string blade_name(const Vec3& pull)
{
    Eigen::Index axis = 0;
    pull.cwiseAbs().maxCoeff(&axis);
    const bool positive = pull[axis] > 0.0;
    if (axis == 0)
        return positive ? "left_blade" : "right_blade";
    if (axis == 1)
        return positive ? "back_blade" : "front_blade";
    return positive ? "upper_blade" : "lower_blade";
}

fem::HookDrive drive_of(const HookSpec& spec)
{
    fem::HookDrive drive { .displacement = spec.opening_mm * spec.direction };
    if (spec.pull.force_N)
        drive.force_N = *spec.pull.force_N * spec.direction;
    drive.force_limit_N = spec.pull.force_limit_N.value_or(drive.force_limit_N);
    drive.grip_N_per_mm = spec.pull.grip_N_per_mm.value_or(drive.grip_N_per_mm);
    return drive;
}

} // namespace retractor::planner
