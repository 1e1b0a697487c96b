#include "planner/plan/wound_view.h"

#include "mesh/image/skeleton.h"
#include "mesh/surface/wound_surface.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace retractor::planner {

namespace {

    constexpr int kTargetSamples = 2000;

    /// The organ that contains a spherical target. This organ is operated on, so it does not block the view of the
    /// target.
    const mesh::LabelInfo* organ_of_sphere(Patient& patient, const TargetSpec& target)
    {
        if (!target.is_sphere())
            return nullptr;
        const auto labels = patient.labels();
        const mesh::LabelInfo* info
            = mesh::find_label(patient.planned_case().label_table, mesh::label_at(*labels, target.centre));
        return info != nullptr && info->role != mesh::Role::wall ? info : nullptr;
    }

    std::vector<Occluder> occluders(const PlannedField& field, const Points& displacement, Patient& patient)
    {
        const Case& planned_case = patient.planned_case();
        const mesh::LabelTable& table = planned_case.label_table;
        std::vector<Occluder> all;
        all.push_back({ .name = "wall",
            .surface = mesh::deformed_boundary(field.wall, displacement),
            .labels = table,
            .material = {},
            .wall = true });
        std::vector<Label> bones;
        for (const mesh::LabelInfo& info : table)
            if (info.role == mesh::Role::wall && is_skeleton(info))
                bones.push_back(info.id);
        all.push_back({ .name = "bone",
            .surface = mesh::tissue_surface(field.wall, displacement, bones).surface,
            .labels = table,
            .material = "bone",
            .wall = true });
        all.push_back({ .name = "wall beyond the model",
            .surface = field.remaining_wall,
            .labels = {},
            .material = {},
            .wall = true });
        const mesh::LabelInfo* operated_on = organ_of_sphere(patient, field.approach.target);
        for (const mesh::LabelInfo& info : table) {
            const bool operated
                = info.name == field.approach.target.label || (operated_on != nullptr && info.id == operated_on->id);
            if (!operated && stays_in_place(info, field.approach, patient))
                all.push_back({ .name = info.name,
                    .surface = *patient.organ(info.name),
                    .labels = {},
                    .material = info.material,
                    .wall = false });
        }
        return all;
    }

} // namespace

WoundView look_through(const PlannedField& field, const Points& displacement, Patient& patient, const Job& job)
{
    WoundView view;
    const WoundEdges edges = wound_edges(field.wall, field.lips, mesh::SweptBlade(blade_of(field.approach)));
    view.geometry = opening_geometry(edges, field.wall, displacement);
    const std::shared_ptr<const TriMesh> target = patient.target(field.approach.target);
    const Vec3 aim = surface_centre(*target);
    const ViewSpec& eyes = field.approach.view;
    const double to_aim = (view.geometry.centre - aim).norm();
    const ViewCone cone
        = cone_through_opening(view.geometry, aim, to_aim + eyes.eye_distance_mm, eyes.half_angle_deg, eyes.eye_count);
    view.exposure = measure_exposure(*target, occluders(field, displacement, patient), cone, kTargetSamples, job);
    view.working_distance_mm = working_distance_mm(view.geometry, *target, aim, cone.axis).value_or(to_aim);
    if (const mesh::LabelInfo* organ = organ_of_sphere(patient, field.approach.target))
        view.message = "the target sphere lies in the " + organ->name
            + "; this organ does not count as blocking the view of the target";
    return view;
}

} // namespace retractor::planner
