#include "planner/approach/hook_patches.h"

#include "fem/statics/hook.h"
#include "mesh/base/error.h"
#include "mesh/image/skeleton.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace retractor::planner {

namespace {

    /// The place of a hook on the blade: along the incision and below the skin.
    struct HookPlace {
        Vec3 centre, along, depth;
    };

    HookPlace hook_place(const Approach& approach, const HookSpec& spec)
    {
        const IncisionPlace place = incision_place(approach, spec.along_mm);
        const Vec3 depth = place.of(approach.directions).normalized();
        const Vec3 step = approach.incision[place.segment + 1] - approach.incision[place.segment];
        return { place.of(approach.incision) + spec.depth_mm * depth, step / step.norm(), depth };
    }

    /// A hook in front of a bone bears on the bone: a retractor's blade lies against the rib and squeezes the muscle
    /// between them flat. Bone vertices under the patch, up to this distance behind it, move with the hook. Otherwise
    /// the layer between hook and rib would have to be crushed to nothing before the rib moves.
    constexpr double kBearingMm = 8.0;
    /// Share of the patch's width, to either side of the middle, over which the patch bears on bone. The bone can then
    /// turn on the hook.
    constexpr double kBearingShare = 0.25;

    std::vector<VertexId> bone_vertices(const mesh::TetMesh& mesh, const mesh::LabelTable& table)
    {
        std::set<VertexId> vertices;
        for (TetId t = 0; t < static_cast<TetId>(mesh.tet_count()); ++t)
            if (mesh::is_skeleton(*mesh::find_label(table, mesh.labels[static_cast<std::size_t>(t)])))
                for (const VertexId v : mesh.tet(t))
                    vertices.insert(v);
        return { vertices.begin(), vertices.end() };
    }

    bool is_behind_patch(const HookSpec& spec, const HookPlace& place, const Vec3& point)
    {
        const Vec3 offset = point - place.centre;
        const double behind = offset.dot(spec.direction);
        return behind >= 0.0 && behind <= kBearingMm
            && std::abs(offset.dot(place.along)) <= kBearingShare * spec.patch_width_mm
            && std::abs(offset.dot(place.depth)) <= 0.5 * spec.patch_height_mm;
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
    const std::vector<VertexId> bones = bone_vertices(wall, table);
    const std::set<VertexId> held(supports.fixed.begin(), supports.fixed.end());
    std::vector<fem::HookPatch> patches;
    for (const HookSpec& spec : approach.hooks) {
        const HookPlace place = hook_place(approach, spec);
        const std::vector<VertexId> on_lip = fem::hook_patch_nodes(wall, lip_of_side[spec.side], place.centre,
            place.along, place.depth, spec.patch_width_mm, spec.patch_height_mm, spec.name);
        std::set<VertexId> nodes(on_lip.begin(), on_lip.end());
        for (const VertexId v : bones)
            if (is_behind_patch(spec, place, wall.vertices.row(v).transpose()))
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
