#include "planner/palpation/through_wound.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/surface/wound_surface.h"
#include "planner/approach/hook_mesh.h"
#include "planner/measures/sight/ray_scene.h"
#include "planner/plan/wound_view.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
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

    /// Which labels share a face of a voxel with this one.
    std::vector<std::uint8_t> neighbours_of(const mesh::LabelVolume& labels, Label label)
    {
        std::vector<std::uint8_t> beside(std::numeric_limits<Label>::max() + std::size_t { 1 }, 0);
        const auto& size = labels.grid.size;
        mesh::visit_voxels(labels, [&](int i, int j, int k, Label here) {
            const auto look = [&](int x, int y, int z) {
                if (x >= size[0] || y >= size[1] || z >= size[2])
                    return;
                const Label next = labels.voxels[labels.grid.offset(x, y, z)];
                if (here == label)
                    beside[next] = 1;
                if (next == label)
                    beside[here] = 1;
            };
            look(i + 1, j, k);
            look(i, j + 1, k);
            look(i, j, k + 1);
        });
        return beside;
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
    if (target->material == "vessel") {
        const std::vector<std::uint8_t> beside = neighbours_of(*labels, target->id);
        for (const mesh::LabelInfo& info : table)
            if (info.material == "vessel" && info.id != target->id && beside[info.id] != 0)
                structure.push_back(info.name);
    }
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
