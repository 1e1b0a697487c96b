#include "ui/plan_scene/plan_scene.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/surface/wound_surface.h"
#include "planner/approach/approach_draft.h"
#include "planner/case/target_site.h"
#include "planner/measures/comparison.h"
#include "planner/measures/metrics.h"
#include "planner/plan/wound_view.h"
#include "planner/wall/image_end.h"
#include "planner/wall/skin_pits.h"
#include "planner/wall/unmeshed_wall.h"
#include "ui/plan_scene/label_surfaces.h"
#include "ui/plan_scene/vessel_surfaces.h"
#include "ui/scene/linked_slices.h"
#include "ui/scene/tissue_colors.h"
#include "ui/scene/vtk/identifier_picture.h"
#include "ui/scene/vtk/simplify_surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace retractor::ui {

namespace {

    constexpr const char* kEstimated = " (estimated)"; ///< behind the name of a structure

    /// Share of the picture's height that the opening fills in the surgeon's eye view.
    constexpr double kOpeningShare = 0.75;
    constexpr double kOverviewTiltDeg = 25.0;
    /// Share of the body's triangles round a wall that is cut by hand. The picture is drawn many times a second.
    constexpr double kSurroundingsShare = 0.2;
    /// Longest edge of the surroundings, much shorter than the region's width.
    constexpr double kLongestSurroundingMm = 8.0;
    /// Grey, as no tissue is: here the CT ends.
    constexpr Color kImageEnd { 0.36, 0.38, 0.40 };
    /// Opacity of the organ that is operated on, so that a target inside it shows.
    constexpr double kOperatedOpacity = 0.4;
    /// Opacity of the target where it shines through the wall: faint, so that it is not taken for the target itself.
    constexpr double kGlow = 0.18;
    /// Height of the drawn incision over the skin. The skin surfaces of image and mesh lie up to a voxel apart.
    constexpr double kInkMm = 1.0;
    /// Height over width of a picture of slices, for a chest about as high as wide and its letters, with the slices
    /// along and across the incision below; and the share of its height for the lower row.
    constexpr double kSlicesHeightPerWidth = 0.85, kLowerRow = 0.45;
    /// Tissue shown beyond the ends of the incision, beside it, and above and below the cut, mm.
    constexpr double kBeyondEndsMm = 40.0, kBesideMm = 75.0, kBeyondCutMm = 45.0;
    /// A skin marker's blue is hard to see on a dark image.
    constexpr Color kCutOnSlice { 0.25, 0.90, 1.00 };

    std::string number(double value, int digits, const std::string& unit)
    {
        return formatted("%.*f %s", digits, value, unit.c_str());
    }

    std::string name_in_picture(const planner::Case& planned_case, const std::string& label)
    {
        return planner::is_estimated(planned_case, label) ? label + kEstimated : label;
    }

    SurfaceItem target_item(planner::Patient& patient, const planner::TargetSpec& target)
    {
        SurfaceItem item;
        item.name = target.is_sphere() ? "target"
            : target.is_site()         ? planner::target_name(target)
                                       : name_in_picture(patient.planned_case(), target.label);
        item.mesh = patient.target(target);
        item.look.color = target_color();
        item.target = true;
        return item;
    }

    SurfaceItem wall_item(planner::Patient& patient, const planner::PlannedField& field)
    {
        SurfaceItem item;
        item.name = kWallName;
        item.mesh = std::make_shared<const TriMesh>(drawn_wall(patient, field, field.opening.displacement));
        item.look_of_label = tissue_looks(patient.planned_case().label_table);
        return item;
    }

    /// Adds the organs that stay in place, and deflated lungs where they go.
    void add_organs(Scene& scene, planner::Patient& patient, const planner::Approach& approach)
    {
        for (const mesh::LabelInfo& info : patient.planned_case().label_table) {
            const planner::TargetSpec& target = approach.target;
            const bool is_target = info.name == target.label;
            if ((is_target && !target.is_site()) || !planner::stays_in_place(info, approach, patient))
                continue;
            SurfaceItem organ;
            organ.name = name_in_picture(patient.planned_case(), info.name);
            organ.mesh = patient.organ(info.name);
            if (is_target)
                organ.mesh = std::make_shared<const TriMesh>(planner::surface_beside_site(*organ.mesh, target));
            organ.look = organ_look(info.name, info.material);
            if (!planner::blocks_view(info, approach, patient))
                organ.opacity = kOperatedOpacity;
            scene.surfaces.push_back(std::move(organ));
        }
        for (planner::DeflatedLung& lung : planner::deflated_lungs(approach, patient))
            scene.surfaces.push_back(
                { .name = readable(name_in_picture(patient.planned_case(), lung.label)) + ", deflated",
                    .mesh = std::make_shared<const TriMesh>(std::move(lung.surface)),
                    .look = organ_look(lung.label, lung.material) });
    }

    /// Adds the wall beyond the model and the organs: what blocks the rays of the exposure, too.
    void add_remaining_anatomy(Scene& scene, planner::Patient& patient, const planner::PlannedField& field)
    {
        const mesh::LabelTable& table = patient.planned_case().label_table;
        if (!field.remaining_wall.triangles.empty()) {
            SurfaceItem rest;
            rest.name = kBeyondName;
            TriMesh wall = field.remaining_wall;
            planner::keep_within_image(wall.vertices, patient.labels()->grid, planner::image_ends(*patient.labels()));
            rest.mesh = std::make_shared<const TriMesh>(std::move(wall));
            rest.look_of_label = tissue_looks(table);
            scene.surfaces.push_back(std::move(rest));
        }
        if (const auto end = patient.image_end(); !end->triangles.empty())
            scene.surfaces.push_back({ .name = std::string(kImageEndName),
                .mesh = end,
                .look = { kImageEnd, Finish::matte, 0.0 },
                .smooth = false });
        add_organs(scene, patient, field.approach);
    }

    void add_hooks(Scene& scene, const planner::PlannedField& field)
    {
        for (const planner::HookShape& hook :
            planner::placed_hooks(field, field.opening.displacement, field.geometry)) {
            SurfaceItem steel;
            steel.name = hook.name;
            steel.mesh = std::make_shared<const TriMesh>(planner::hook_mesh(hook));
            steel.look = steel_look();
            scene.surfaces.push_back(std::move(steel));
        }
    }

    /// Says first that the numbers are not to be used, and therefore not shown.
    void add_alarm(const planner::FieldMetrics& m, std::vector<LegendLine>& lines)
    {
        constexpr Color kAlarm { 0.95, 0.25, 0.2 };
        const bool turned_over = m.inverted_elements > 0 && m.mechanics_status.starts_with("inverted");
        if (m.mechanics_status != "converged" && !turned_over)
            lines.push_back({ "NOT IN EQUILIBRIUM: its numbers are not shown", {}, kAlarm });
        else if (!planner::is_solved(m))
            lines.push_back({ "NOT USABLE: its numbers are not shown", {}, kAlarm });
    }

    std::vector<LegendLine> legend_of(const planner::FieldMetrics& m)
    {
        const bool bars = m.error && m.error->message.empty();
        // An error bar has no more than two meaningful digits.
        const auto bar
            = [&](double value) { return bars ? "± " + number(value, value < 9.95 ? 1 : 0, "") : std::string(); };
        std::vector<LegendLine> lines;
        const bool is_estimated
            = std::find(m.estimated.begin(), m.estimated.end(), m.target_spec.label) != m.estimated.end();
        add_alarm(m, lines);
        lines.push_back({ "target: " + readable(m.target) + (is_estimated ? kEstimated : ""), {}, target_color() });
        if (!planner::is_solved(m))
            return lines;
        lines.push_back({ "seen by the best eye",
            number(100.0 * m.seen_best_eye, 0, bar(bars ? 100.0 * m.error->seen_best_eye : 0.0) + "%"), std::nullopt });
        lines.push_back({ "  with two eyes and a lamp", number(100.0 * m.seen_two_eyes, 0, "%"), std::nullopt });
        lines.push_back(
            { "  reached by two instruments", number(100.0 * m.reached_by_two_instruments, 0, "%"), std::nullopt });
        lines.push_back({ "opening",
            number(m.opening_width_mm, 0, bar(bars ? m.error->opening_width_mm : 0.0) + "mm") + " / "
                + number(m.opening_area_mm2 / 100.0, 1, "cm2"),
            std::nullopt });
        lines.push_back({ "working distance", number(m.working_distance_mm, 0, "mm"), std::nullopt });
        lines.push_back({ "incision", number(m.incision_length_mm, 0, "mm"), std::nullopt });
        lines.push_back({ m.retractor ? "retractor force, one side" : "hook force, one side",
            number(
                m.hook_force_N, 0, planner::forces_are_known(m) ? "N" : bar(bars ? m.error->hook_force_N : 0.0) + "N"),
            std::nullopt });
        const auto yielded = std::count_if(m.hooks.begin(), m.hooks.end(), [](const auto& h) { return h.yielded; });
        if (yielded > 0)
            lines.push_back({ "hooks that yield", std::to_string(yielded) + " of " + std::to_string(m.hooks.size()),
                std::nullopt });
        // The bone that is most in the way comes first; the report names all.
        const std::size_t bones = m.bone_in_sight.size();
        lines.push_back({ "bone in sight",
            bones == 0       ? "none"
                : bones == 1 ? readable(m.bone_in_sight[0])
                             : readable(m.bone_in_sight[0]) + " and " + std::to_string(bones - 1) + " more",
            std::nullopt });
        return lines;
    }

    /// The up vector: towards the patient's head, or towards the patient's left when the view is along the body.
    Vec3 up_for(const planner::AnatomicalFrame& frame, const Vec3& sight)
    {
        return std::abs(frame.superior.dot(sight.normalized())) > 0.9 ? frame.anterior : frame.superior;
    }

    Scene field_scene(planner::Patient& patient, const planner::PlannedField& field)
    {
        Scene scene;
        scene.surfaces.push_back(wall_item(patient, field));
        scene.surfaces.push_back(target_item(patient, field.approach.target));
        add_remaining_anatomy(scene, patient, field);
        for (SurfaceItem& vessel : vessel_surfaces(patient.planned_case(), field))
            scene.surfaces.push_back(std::move(vessel));
        add_hooks(scene, field);
        scene.legend = legend_of(field.metrics);
        return scene;
    }

    LineItem incision_line(const planner::Approach& approach, bool on_top)
    {
        LineItem line;
        line.name = kIncisionName;
        line.points = approach.incision;
        if (!on_top)
            for (std::size_t i = 0; i < line.points.size(); ++i)
                line.points[i] -= kInkMm * approach.directions[i].normalized();
        line.color = incision_color();
        line.on_top = on_top;
        return line;
    }

    /// Colours of the labels' outlines on slices.
    std::map<Label, Color> outlines_of(planner::Patient& patient, const planner::TargetSpec& target)
    {
        std::map<Label, Color> outlines;
        for (const mesh::LabelInfo& info : patient.planned_case().label_table)
            outlines[info.id]
                = info.name == target.label && !target.is_site() ? target_color() : tissue_look(info.material).color;
        return outlines;
    }

    /// The circle in which a slice through its centre meets a spherical target, or a site.
    LineItem sphere_outline(const planner::TargetSpec& target, SlicePlane plane)
    {
        constexpr int kCorners = 96;
        const Vec3 u = plane == SlicePlane::sagittal ? Vec3::UnitY() : Vec3::UnitX();
        const Vec3 v = plane == SlicePlane::axial ? Vec3::UnitY() : Vec3::UnitZ();
        LineItem line;
        line.name = "target";
        line.color = target_color();
        line.on_top = true;
        for (int n = 0; n <= kCorners; ++n) {
            const double angle = 2.0 * std::numbers::pi * n / kCorners;
            line.points.push_back(target.centre + target.radius_mm * (std::cos(angle) * u + std::sin(angle) * v));
        }
        return line;
    }

    Box bounds_of(const TriMesh& mesh)
    {
        return { mesh.vertices.colwise().minCoeff().transpose(), mesh.vertices.colwise().maxCoeff().transpose() };
    }

    Vec3 mean_direction(const planner::Approach& approach)
    {
        Vec3 sum = Vec3::Zero();
        for (const Vec3& direction : approach.directions)
            sum += direction;
        return sum.normalized();
    }

    /// A camera outside, aimed at the incision and tilted towards the feet so that the relief shows.
    Camera outside_camera(planner::Patient& patient, const planner::Approach& approach)
    {
        const planner::AnatomicalFrame frame = patient.frame();
        const Vec3 inward = mean_direction(approach);
        const Vec3 axis = inward.cross(frame.superior);
        const double tilt = axis.norm() > 0.1 ? kOverviewTiltDeg * std::numbers::pi / 180.0 : 0.0;
        const Vec3 sight = tilt == 0.0 ? inward : Vec3(Eigen::AngleAxisd(tilt, axis.normalized()) * inward);
        return camera_for_box(bounds_of(*patient.body()), sight, up_for(frame, sight));
    }

} // namespace

TriMesh drawn_wall(planner::Patient& patient, const planner::PlannedField& field, const Points& displacement)
{
    const TriMesh at_rest = mesh::deformed_boundary(field.wall, {});
    const mesh::MeshSizing sizing = planner::mesh_sizing_of(field.approach, patient.planned_case().label_table);
    TriMesh boundary = mesh::deformed_boundary(field.wall, displacement);
    boundary.labels = planner::drawn_labels(at_rest, *patient.labels(), sizing);
    const mesh::LabelTable& table = patient.labels()->table;
    if (const auto skin = std::ranges::find(table, "skin", &mesh::LabelInfo::material); skin != table.end())
        planner::lift_pits(boundary, at_rest, *patient.body(), field.approach.incision, skin->id);
    planner::keep_within_image(boundary.vertices, patient.labels()->grid, planner::image_ends(*patient.labels()));
    return planner::without_rim(
        std::move(boundary), at_rest, sizing, planner::drawn_rim_width_mm(sizing.region_mm, field.approach.depth_mm));
}

TriMesh remaining_wall_at_rest(planner::Patient& patient, const planner::PlannedField& field)
{
    const mesh::MeshSizing sizing = planner::mesh_sizing_of(field.approach, patient.planned_case().label_table);
    return planner::unmeshed_wall_region(*patient.body(), *patient.labels(), sizing, field.wall,
        Points::Zero(field.wall.vertices.rows(), 3),
        planner::drawn_rim_width_mm(sizing.region_mm, field.approach.depth_mm));
}

std::map<Label, std::string> label_names(const planner::Case& planned_case)
{
    std::map<Label, std::string> names;
    for (const mesh::LabelInfo& info : planned_case.label_table)
        names[info.id] = name_in_picture(planned_case, info.name);
    return names;
}

Scene surgeon_scene(planner::Patient& patient, const planner::PlannedField& field)
{
    Scene scene = field_scene(patient, field);
    scene.title = planner::spoken_name(field.approach) + ": through the incision";
    scene.camera.eye = field.best_eye.eye;
    scene.camera.aim = field.best_eye.aim;
    scene.camera.up = up_for(patient.frame(), field.best_eye.eye - field.best_eye.aim);
    const double half_size = 0.5 * std::max(field.geometry.length_mm, field.geometry.width_mm) / kOpeningShare;
    const double distance = (scene.camera.eye - field.geometry.centre).norm();
    scene.camera.view_angle_deg = 2.0 * std::atan(half_size / distance) * 180.0 / std::numbers::pi;
    return scene;
}

Scene surgeon_scene_without(
    planner::Patient& patient, const planner::PlannedField& field, const std::vector<std::string>& labels)
{
    Scene scene = surgeon_scene(patient, field);
    std::erase_if(scene.surfaces, [&](const SurfaceItem& item) {
        return std::ranges::any_of(labels, [&](const std::string& label) {
            return item.name == name_in_picture(patient.planned_case(), label)
                || (item.target && label == field.approach.target.label);
        });
    });
    return scene;
}

std::vector<LegendLine> estimated_lines(std::vector<LegendLine> legend)
{
    std::erase_if(legend, [](const LegendLine& line) { return !line.key.ends_with(kEstimated); });
    return legend;
}

Scene overview_scene(planner::Patient& patient, const planner::PlannedField& field)
{
    Scene scene = field_scene(patient, field);
    scene.title = planner::spoken_name(field.approach) + ": overview";
    scene.camera = outside_camera(patient, field.approach);
    return scene;
}

std::vector<Scene> slice_scenes(planner::Patient& patient, const Vec3& point, const std::map<Label, Color>& colors)
{
    std::vector<Scene> scenes;
    for (const auto& [plane, title] : { std::pair { SlicePlane::axial, "axial" },
             std::pair { SlicePlane::coronal, "coronal" }, std::pair { SlicePlane::sagittal, "sagittal" } }) {
        Scene scene;
        scene.title = title;
        SliceItem slice;
        slice.image = patient.ct();
        slice.plane = plane;
        slice.point = point;
        slice.labels = patient.labels();
        slice.outline_of_label = colors;
        scene.slices.push_back(std::move(slice));
        scene.lines = vessel_lines(patient.planned_case());
        scenes.push_back(std::move(scene));
    }
    return scenes;
}

std::vector<Scene> slice_scenes(
    planner::Patient& patient, const planner::TargetSpec& target, const std::map<Label, Color>& colors)
{
    if (!target.is_sphere() && !target.is_site())
        return slice_scenes(patient, planner::surface_centre(*patient.target(target)), colors);
    std::vector<Scene> scenes = slice_scenes(patient, target.centre, colors);
    for (Scene& scene : scenes)
        scene.lines.push_back(sphere_outline(target, scene.slices.front().plane));
    return scenes;
}

std::vector<Scene> slice_scenes(planner::Patient& patient, const planner::Approach& approach)
{
    const std::map<Label, Color> outlines = outlines_of(patient, approach.target);
    std::vector<Scene> scenes = slice_scenes(patient, approach.target, outlines);
    for (Scene& scene : scenes) {
        scene.lines.push_back(incision_line(approach, true)); // slice_with_lines() takes what lies near the slice
        scene.lines.back().color = kCutOnSlice;
        scene.lines.back().width_px = 6.0;
    }
    return scenes;
}

namespace {

    /// ": a flat section; the cut curves up to 12 mm out of it" where the cut leaves the slice's plane so far that the
    /// picture may show it in tissue through which it does not go; else nothing.
    std::string curved_words(const SliceItem& slice, const std::vector<Vec3>& cut)
    {
        constexpr double kOutMm = 3.0; // half of what a blade must leave free between ribs
        const Vec3 normal = slice.oblique->right.cross(slice.oblique->up);
        double farthest = 0.0;
        for (const Vec3& p : cut)
            farthest = std::max(farthest, std::abs(normal.dot(p - slice.point)));
        return farthest > kOutMm ? formatted(": a flat section; the cut curves up to %.0f mm out of it", farthest)
                                 : std::string();
    }

} // namespace

std::vector<Scene> incision_slice_scenes(planner::Patient& patient, const planner::Approach& approach)
{
    RETRACTOR_ASSERT(approach.incision.size() >= 2 && approach.directions.size() == approach.incision.size());
    const std::map<Label, Color> outlines = outlines_of(patient, approach.target);
    const auto scene_of = [&](const std::string& title, const Vec3& middle, const Vec3& along, const Vec3& inward,
                              double half_width_mm) {
        const Vec3 up = -inward.normalized(), right = (along - along.dot(up) * up).normalized();
        Scene scene;
        scene.title = title;
        scene.slices.push_back({ .image = patient.ct(),
            .point = middle - 0.5 * approach.depth_mm * up,
            .oblique = ObliqueSlice { .right = right,
                .up = up,
                .half_width_mm = half_width_mm,
                .half_height_mm = 0.5 * approach.depth_mm + kBeyondCutMm },
            .labels = patient.labels(),
            .outline_of_label = outlines });
        return scene;
    };
    const auto add_cut = [&](Scene& scene, std::vector<Vec3> points) {
        const SliceItem& slice = scene.slices.front();
        const Vec3 normal = slice.oblique->right.cross(slice.oblique->up);
        for (Vec3& p : points)
            p -= normal.dot(p - slice.point) * normal;
        scene.lines.push_back({ .name = std::string(kCutName),
            .points = std::move(points),
            .color = kCutOnSlice,
            .width_px = 5.0,
            .on_top = true });
    };
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : approach.incision)
        middle += p / static_cast<double>(approach.incision.size());
    const Vec3 chord = approach.incision.back() - approach.incision.front();
    std::vector<Scene> scenes { scene_of(
        "along the incision", middle, chord, mean_direction(approach), 0.5 * chord.norm() + kBeyondEndsMm) };
    std::vector<Vec3> outline = approach.incision; // of the cut: along the skin, and back at its depth
    for (std::size_t n = approach.incision.size(); n-- > 0;)
        outline.push_back(approach.incision[n] + approach.depth_mm * approach.directions[n].normalized());
    outline.push_back(approach.incision.front());
    scenes.back().title += curved_words(scenes.back().slices.front(), outline);
    add_cut(scenes.back(), std::move(outline));

    const planner::IncisionPlace place = planner::incision_place(approach, 0.5 * planner::incision_length(approach));
    const Vec3 at = place.of(approach.incision), inward = place.of(approach.directions).normalized();
    const Vec3 across = (approach.incision[place.segment + 1] - approach.incision[place.segment]).cross(inward);
    scenes.push_back(scene_of("across its middle", at, across, inward, kBesideMm));
    const Vec3 deep = at + approach.depth_mm * inward;
    add_cut(scenes.back(), { at, deep });
    scenes.back().words.push_back({ .text = number(approach.depth_mm, 0, "mm deep"),
        .position = deep + 0.2 * kBeyondCutMm * inward,
        .color = kCutOnSlice });
    return scenes;
}

Picture slices_picture(planner::Patient& patient, const planner::Approach& approach, int width, int height)
{
    Picture picture { .width = width,
        .height = std::min(height, static_cast<int>(std::lround(kSlicesHeightPerWidth * width))),
        .viewports = {} };
    const auto add = [&](Scene scene, double left, double right, double bottom, double top) {
        scene.camera = camera_for_slice(
            scene.slices.front(), (right - left) * picture.width / ((top - bottom) * picture.height));
        picture.viewports.push_back(
            { .left = left, .bottom = bottom, .right = right, .top = top, .scene = std::move(scene) });
    };
    std::vector<Scene> upper = slice_scenes(patient, approach), lower = incision_slice_scenes(patient, approach);
    const double share = 1.0 / static_cast<double>(upper.size());
    for (std::size_t i = 0; i < upper.size(); ++i)
        add(slice_with_lines(upper[i], upper[i].slices.front().point), static_cast<double>(i) * share,
            static_cast<double>(i + 1) * share, kLowerRow, 1.0);
    const std::map<Label, std::string> names = label_names(patient.planned_case());
    const double middle = 2.0 / 3.0;
    for (Scene& scene : lower) {
        const bool is_first = &scene == &lower.front();
        add(std::move(scene), is_first ? 0.0 : middle, is_first ? middle : 1.0, 0.0, kLowerRow);
        Viewport& view = picture.viewports.back();
        add_names(view.scene,
            identifier_picture(view.scene.slices.front(), view.scene.camera, names,
                static_cast<int>((view.right - view.left) * picture.width),
                static_cast<int>(kLowerRow * picture.height)));
    }
    return picture;
}

std::vector<SurfaceItem> anatomy_surfaces(planner::Patient& patient, const Job& job)
{
    std::vector<SurfaceItem> surfaces;
    const auto labels = patient.labels();
    for (SurfaceItem& item : label_surfaces(*labels, job)) {
        const mesh::LabelInfo* const info = mesh::find_label(labels->table, item.name);
        if (info == nullptr) // the body
            continue;
        item.look = organ_look(info->name, info->material);
        item.name = name_in_picture(patient.planned_case(), info->name);
        surfaces.push_back(std::move(item));
    }
    for (SurfaceItem& vessel : vessel_surfaces(patient.planned_case()))
        surfaces.push_back(std::move(vessel));
    return surfaces;
}

Scene patient_scene(planner::Patient& patient)
{
    Scene scene;
    scene.title = "patient";
    SurfaceItem body;
    body.name = kBodyName;
    body.mesh = patient.body();
    body.look = tissue_look("skin");
    scene.surfaces.push_back(std::move(body));
    const planner::AnatomicalFrame frame = patient.frame();
    const Vec3 sight = -frame.anterior;
    scene.camera = camera_for_box(bounds_of(*patient.body()), sight, up_for(frame, sight));
    return scene;
}

std::vector<Scene> patient_slices(planner::Patient& patient)
{
    std::map<Label, Color> outlines;
    for (const mesh::LabelInfo& info : patient.planned_case().label_table)
        outlines[info.id] = tissue_look(info.material).color;
    const mesh::ImageGrid& grid = patient.labels()->grid;
    return slice_scenes(
        patient, grid.world(0.5 * Vec3(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1)), outlines);
}

Scene planning_scene(planner::Patient& patient, const planner::Approach& approach)
{
    Scene scene;
    scene.title = planner::spoken_name(approach) + ": incision";
    SurfaceItem body;
    body.name = kBodyName;
    body.mesh = patient.body();
    body.look = tissue_look("skin");
    body.opacity = 0.6;
    scene.surfaces.push_back(std::move(body));
    scene.surfaces.push_back(target_item(patient, approach.target));
    scene.lines.push_back(incision_line(approach, false));
    scene.camera = outside_camera(patient, approach);
    return scene;
}

Scene knife_surroundings(planner::Patient& patient, const planner::Approach& approach)
{
    Scene scene;
    scene.title = planner::spoken_name(approach) + ": by hand";
    scene.surfaces.push_back(target_item(patient, approach.target));
    SurfaceItem glow = scene.surfaces.back();
    glow.name += " behind the wall";
    glow.target = false;
    glow.opacity = kGlow;
    glow.on_top = true;
    scene.surfaces.push_back(std::move(glow));
    add_organs(scene, patient, approach);
    scene.lines.push_back(incision_line(approach, false));
    scene.camera = outside_camera(patient, approach);
    return scene;
}

TriMesh body_beyond(planner::Patient& patient, const planner::Approach& approach, const mesh::TetMesh& wall,
    double rim_mm, const Job& job)
{
    job.report("surroundings", 0.0);
    // Simplified flat parts of the body have few triangles, and one triangle could span the whole region.
    const TriMesh body = with_edges_at_most(simplified(*patient.body(), kSurroundingsShare), kLongestSurroundingMm);
    job.report("surroundings", 0.5);
    const mesh::LabelTable& table = patient.planned_case().label_table;
    return planner::unmeshed_wall_region(
        body, *patient.labels(), planner::mesh_sizing_of(approach, table), wall, Points(), rim_mm, job);
}

Picture view_picture(
    planner::Patient& patient, const planner::PlannedField& field, std::string_view view, int width, int height)
{
    Picture picture;
    picture.width = width;
    picture.height = height;
    if (view == "surgeon") {
        picture.viewports.push_back({ .scene = surgeon_scene(patient, field) });
    } else if (view == "overview") {
        picture.viewports.push_back({ .scene = overview_scene(patient, field) });
    } else if (view == "slices") {
        return slices_picture(patient, field.approach, width, height);
    } else {
        throw InputError("there is no view \"" + std::string(view) + "\"; there are surgeon, overview, slices");
    }
    return picture;
}

} // namespace retractor::ui
