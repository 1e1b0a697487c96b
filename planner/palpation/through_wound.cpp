#include "planner/palpation/through_wound.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/surface/wound_surface.h"
#include "planner/approach/hook_mesh.h"
#include "planner/measures/sight/ray_scene.h"
#include "planner/plan/wound_view.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

namespace retractor::planner {

namespace {

    /// The triangles of each label as surfaces of their own.
    void add_by_label(std::vector<mesh::NamedSurface>& all, const TriMesh& surface, const mesh::LabelTable& table)
    {
        std::map<Label, std::vector<std::array<VertexId, 3>>> triangles;
        for (std::size_t t = 0; t < surface.triangles.size(); ++t)
            triangles[t < surface.labels.size() ? surface.labels[t] : Label {}].push_back(surface.triangles[t]);
        for (auto& [label, of_label] : triangles) {
            const auto info = std::ranges::find(table, label, &mesh::LabelInfo::id);
            mesh::NamedSurface named { .name = info != table.end() ? readable(info->name) : "chest wall",
                .surface = {} };
            named.surface.vertices = surface.vertices;
            named.surface.triangles = std::move(of_label);
            all.push_back(std::move(named));
        }
    }

    /// Whether voxels of two labels share a face.
    bool touch(const mesh::LabelVolume& labels, Label a, Label b)
    {
        const auto& size = labels.grid.size;
        const std::array<std::size_t, 3> stride { 1, static_cast<std::size_t>(size[0]),
            static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) };
        for (std::size_t axis = 0; axis < 3; ++axis)
            for (std::size_t i = 0; i + stride[axis] < labels.voxels.size(); ++i) {
                const Label here = labels.voxels[i], next = labels.voxels[i + stride[axis]];
                if ((here == a && next == b) || (here == b && next == a))
                    return true;
            }
        return false;
    }

} // namespace

std::vector<std::string> palpated_structure(const Approach& approach, Patient& patient)
{
    const auto labels = patient.labels();
    const mesh::LabelTable& table = patient.planned_case().label_table;
    const mesh::LabelInfo* target = approach.target.is_sphere()
        ? mesh::find_label(table, mesh::label_at(*labels, approach.target.centre))
        : mesh::find_label(table, approach.target.label);
    if (target == nullptr || target->role == mesh::Role::wall)
        throw InputError("the target lies in no organ that can be palpated", approach.name, { "target" });
    std::vector<std::string> structure { target->name };
    if (target->material == "vessel")
        for (const mesh::LabelInfo& info : table)
            if (info.material == "vessel" && info.id != target->id && touch(*labels, info.id, target->id))
                structure.push_back(info.name);
    return structure;
}

PalpableThroughWound make_palpable_through(
    const PlannedField& field, Patient& patient, const std::vector<std::string>& structure, const Job& job)
{
    PalpableThroughWound made { .palpable = {}, .structure = structure, .around = {} };
    PalpableRequest request;
    request.structure = structure;
    constexpr const char* kTarget = "target";
    request.sites = { { kTarget, field.best_eye.aim } };
    made.palpable = make_palpable(patient, request, job);
    // Simulated hands work at the first site.
    std::ranges::stable_partition(
        made.palpable.scene.sites, [&](const datasets::TouchSite& site) { return site.name.starts_with(kTarget); });
    const mesh::LabelTable& table = patient.planned_case().label_table;
    const auto is_palpated
        = [&](const std::string& name) { return std::ranges::find(structure, name) != structure.end(); };
    add_by_label(made.around, mesh::deformed_boundary(field.wall, field.opening.displacement), table);
    made.around.push_back({ "chest wall beyond the model", field.remaining_wall });
    for (const HookShape& hook : placed_hooks(field, field.opening.displacement, field.geometry))
        made.around.push_back({ readable(hook.name), hook_mesh(hook) });
    for (Occluder& organ : organ_occluders(field.approach, patient))
        if (!is_palpated(organ.name))
            made.around.push_back({ readable(organ.name), std::move(organ.surface) });
    // The target does not block the view of itself; it stops a finger where another structure is palpated.
    for (const mesh::LabelInfo& info : table)
        if (!is_palpated(info.name) && stays_in_place(info, field.approach, patient)
            && !blocks_view(info, field.approach, patient))
            made.around.push_back({ readable(info.name), *patient.organ(info.name) });
    return made;
}

} // namespace retractor::planner
