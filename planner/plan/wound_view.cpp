#include "planner/plan/wound_view.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"
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

    TriMesh moved(TriMesh surface, const Vec3& by)
    {
        surface.vertices.rowwise() += by.transpose();
        return surface;
    }

    std::vector<Occluder> occluders(const PlannedField& field, const Points& displacement,
        const OpeningGeometry& opening, Patient& patient, const OrganPlaces& places)
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
        for (const HookShape& hook : placed_hooks(field, displacement, opening))
            all.push_back(
                { .name = hook.name, .surface = hook_mesh(hook), .labels = {}, .material = "steel", .wall = true });
        for (Occluder& organ : organ_occluders(field.approach, patient, places))
            all.push_back(std::move(organ));
        return all;
    }

    /// Distance from the middle of ViewSpec::eye_distance_mm by which a surgeon leans in and back, mm (ours).
    constexpr double kLeanMm = 100.0;

    /// The rays' scene of a wound, and where to look from.
    struct Outlook {
        OpeningGeometry geometry;
        RayScene scene;
        std::vector<SurfaceSample> samples;
        EyePlaces places;

        Outlook(const PlannedField& field, const Points& displacement, Patient& patient, const Job& job,
            const OrganPlaces& organs = {})
            : geometry(opening_geometry(wound_edges(field.wall, field.lips, mesh::SweptBlade(blade_of(field.approach))),
                field.wall, displacement))
            , scene(moved(*patient.target(field.approach.target), organs.by),
                  occluders(field, displacement, geometry, patient, organs), job)
            , samples(surface_samples(scene.target(), kTargetSamples))
        {
            places = eye_places_through(geometry, aim_through(scene, geometry, samples), field.approach.view);
        }
    };

} // namespace

bool blocks_view(const mesh::LabelInfo& label, const Approach& approach, Patient& patient)
{
    const mesh::LabelInfo* operated_on = organ_of_sphere(patient, approach.target);
    const bool is_target = label.name == approach.target.label && !approach.target.is_site();
    return !is_target && (operated_on == nullptr || label.id != operated_on->id)
        && stays_in_place(label, approach, patient);
}

std::vector<Occluder> organ_occluders(const Approach& approach, Patient& patient, const OrganPlaces& places)
{
    std::vector<Occluder> organs;
    organs.push_back({ .name = "end of the image",
        .surface = moved(*patient.image_end(), places.by),
        .labels = {},
        .material = {},
        .wall = false });
    for (const mesh::LabelInfo& info : patient.planned_case().label_table)
        if (blocks_view(info, approach, patient))
            organs.push_back({ .name = info.name,
                .surface = moved(*patient.organ(info.name), places.by),
                .labels = {},
                .material = info.material,
                .wall = false });
    if (!(places.lung_share > 0.0))
        return organs;
    for (DeflatedLung& lung : deflated_lungs(approach, patient, places.lung_share))
        organs.push_back({ .name = std::move(lung.name),
            .surface = moved(std::move(lung.surface), places.by),
            .labels = {},
            .material = std::move(lung.material),
            .wall = true });
    return organs;
}

EyePlaces eye_places_through(const OpeningGeometry& opening, const Vec3& aim, const ViewSpec& eyes)
{
    const double to_opening = (opening.centre - aim).norm();
    const double lean = std::min(kLeanMm, 0.5 * eyes.eye_distance_mm);
    EyePlaces places;
    places.cone
        = cone_through_opening(opening, aim, to_opening + eyes.eye_distance_mm, eyes.half_angle_deg, eyes.eye_count);
    places.nearest_mm = places.cone.eye_distance_mm - lean;
    places.farthest_mm = places.cone.eye_distance_mm + lean;
    return places;
}

std::vector<HookShape> placed_hooks(
    const PlannedField& field, const Points& displacement, const OpeningGeometry& opening)
{
    RETRACTOR_ASSERT(field.hooks.size() <= field.approach.hooks.size());
    std::vector<HookShape> shapes;
    for (std::size_t i = 0; i < field.hooks.size(); ++i) {
        const fem::HookPatch& patch = field.hooks[i];
        Vec3 centre = Vec3::Zero();
        for (const VertexId v : patch.nodes)
            centre += (field.wall.vertices.row(v) + displacement.row(v)).transpose();
        const HookSpec& spec = field.approach.hooks[i];
        // A blade that turns stood square to the skin; a hook stands on the opened wound.
        const Vec3 outward = patch.turns()
            ? Vec3(-(patch.rotation * incision_place(field.approach, spec.along_mm).of(field.approach.directions)))
            : opening.normal;
        const Vec3 pull = patch.rotation * spec.direction;
        constexpr double kStraightOut = 1e-3;
        if (pull.cross(outward).norm() < kStraightOut) // a hook that lifts has no blade beside the wound
            continue;
        shapes.push_back({ .name = patch.name,
            .position = centre / static_cast<double>(patch.nodes.size()),
            .pull = pull,
            .outward = outward,
            .width_mm = spec.patch_width_mm,
            .depth_mm = spec.patch_height_mm,
            .height_mm = std::max(spec.depth_mm, spec.patch_height_mm / 2.0),
            .shaft_mm = 60.0 });
    }
    return shapes;
}

WoundView look_through(const PlannedField& field, const Points& displacement, Patient& patient, const Job& job)
{
    Outlook outlook(field, displacement, patient, job);
    const ViewCone& cone = outlook.places.cone;
    WoundView view;
    view.best = best_eye(outlook.scene, outlook.places, outlook.samples, job);
    if (view.best.status == ExposureStatus::done)
        add_two_eyes_and_instruments(view.best, outlook.scene, outlook.geometry, outlook.samples, job);
    if (view.best.status == ExposureStatus::done)
        add_reach(view.best, outlook.scene, outlook.geometry, outlook.samples, job);
    view.exposure = measure_exposure(outlook.scene, cone, kTargetSamples, job);
    view.working_distance_mm = working_distance_mm(outlook.geometry, outlook.scene.target(), cone.aim, cone.axis)
                                   .value_or((outlook.geometry.centre - cone.aim).norm());
    view.from_target = opening_from(outlook.geometry,
        wound_edges(field.wall, field.lips, mesh::SweptBlade(blade_of(field.approach))), field.wall, displacement,
        view.best.aim);
    if (const mesh::LabelInfo* organ = organ_of_sphere(patient, field.approach.target))
        view.message = "the target sphere lies in the " + readable(organ->name)
            + "; this organ does not count as blocking the view of the target";
    view.geometry = std::move(outlook.geometry);
    return view;
}

double seen_from_best_eye(const PlannedField& field, const Points& displacement, Patient& patient, const Job& job,
    const OrganPlaces& places, const std::optional<Vec3>& up)
{
    Outlook outlook(field, displacement, patient, job, places);
    outlook.places.up = up;
    return best_eye(outlook.scene, outlook.places, outlook.samples, job).seen_fraction;
}

} // namespace retractor::planner
