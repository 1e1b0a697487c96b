#include "ui/plan_scene/case_picture.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/case/target_site.h"
#include "ui/plan_scene/label_surfaces.h"
#include "ui/plan_scene/plan_scene.h"
#include "ui/scene/label_colors.h"
#include "ui/scene/linked_slices.h"
#include "ui/scene/tissue_colors.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

namespace retractor::ui {

namespace {

    constexpr double kLegendShare = 0.19;

    std::string caption_of_target(const planner::TargetSpec& target)
    {
        return target.is_sphere() ? "target sphere" : "target: " + readable(planner::target_name(target));
    }

    /// The labels on the three planes.
    std::set<Label> labels_on(const mesh::LabelVolume& labels, const Vec3& point)
    {
        std::set<Label> met;
        const Vec3 at = labels.grid.index(point).array().round();
        for (int axis = 0; axis < 3; ++axis) {
            std::array<int, 3> low { 0, 0, 0 }, high { labels.grid.size };
            const auto a = static_cast<std::size_t>(axis);
            if (at[axis] < 0.0 || at[axis] >= labels.grid.size[a])
                continue;
            low[a] = static_cast<int>(at[axis]);
            high[a] = low[a] + 1;
            for (int k = low[2]; k < high[2]; ++k)
                for (int j = low[1]; j < high[1]; ++j)
                    for (int i = low[0]; i < high[0]; ++i)
                        met.insert(labels.voxels[labels.grid.offset(i, j, k)]);
        }
        return met;
    }

    /// The centroid of all labelled voxels.
    Vec3 middle_of(const mesh::LabelVolume& labels)
    {
        Vec3 sum = Vec3::Zero();
        std::size_t count = 0, at = 0;
        for (int k = 0; k < labels.grid.size[2]; ++k)
            for (int j = 0; j < labels.grid.size[1]; ++j)
                for (int i = 0; i < labels.grid.size[0]; ++i, ++at)
                    if (labels.voxels[at] != 0) {
                        sum += Vec3(i, j, k);
                        ++count;
                    }
        return labels.grid.world(sum / static_cast<double>(std::max<std::size_t>(count, 1)));
    }

    Scene legend_panel(const std::vector<LegendLine>& lines)
    {
        Scene scene;
        scene.orientation_marker = scene.scale_bar = false;
        scene.background_low = scene.background_high = { 0.09, 0.11, 0.13 };
        scene.legend_share = 1.0;
        scene.legend = lines;
        return scene;
    }

    Picture slices_picture(
        planner::Patient& patient, const std::optional<planner::TargetSpec>& target, int width, int height)
    {
        std::map<Label, Color> colors = label_colors(patient.planned_case().label_table);
        const std::string target_label = target && !target->is_site() ? target->label : "";
        if (const mesh::LabelInfo* info = mesh::find_label(patient.planned_case().label_table, target_label))
            colors[info->id] = target_color();
        std::vector<LegendLine> lines;
        if (target)
            lines.push_back({ caption_of_target(*target), " ", target_color() });
        std::vector<Scene> scenes = target ? slice_scenes(patient, *target, colors)
                                           : slice_scenes(patient, middle_of(*patient.labels()), colors);
        RETRACTOR_ASSERT(!scenes.empty() && !scenes.front().slices.empty());
        const std::set<Label> met = labels_on(*patient.labels(), scenes.front().slices.front().point);
        for (const mesh::LabelInfo& info : patient.planned_case().label_table)
            if (met.contains(info.id) && info.name != target_label && level_of(info.name).empty())
                lines.push_back({ readable(info.name), " ", colors.at(info.id) });

        Picture picture { .width = width, .height = height, .viewports = {} };
        const double share = (1.0 - kLegendShare) / static_cast<double>(scenes.size());
        picture.height = std::min(height, static_cast<int>(std::lround(1.4 * share * width)));
        for (std::size_t i = 0; i < scenes.size(); ++i) {
            const double left = static_cast<double>(i) * share;
            const Vec3 point = scenes[i].slices.front().point;
            Scene scene = slice_with_lines(std::move(scenes[i]), point);
            scene.camera = camera_for_slice(scene.slices.front(), share * width / picture.height);
            picture.viewports.push_back({ .left = left, .right = left + share, .scene = std::move(scene) });
        }
        picture.viewports.push_back({ .left = 1.0 - kLegendShare, .scene = legend_panel(lines) });
        return picture;
    }

    Picture overview_picture(
        planner::Patient& patient, const std::optional<planner::TargetSpec>& target, int width, int height)
    {
        Scene scene;
        scene.title = "overview";
        const auto labels = patient.labels();
        scene.surfaces = label_surfaces(*labels, patient.job());
        if (target) {
            for (SurfaceItem& item : scene.surfaces)
                if (item.name == target->label && target->is_site())
                    item.mesh = std::make_shared<const TriMesh>(planner::surface_beside_site(*item.mesh, *target));
            if (!target->is_site())
                std::erase_if(scene.surfaces, [&](const SurfaceItem& item) { return item.name == target->label; });
            SurfaceItem item;
            item.name = caption_of_target(*target);
            item.mesh = patient.target(*target);
            item.look.color = target_color();
            item.target = true;
            scene.surfaces.push_back(std::move(item));
            scene.legend.push_back({ caption_of_target(*target), " ", target_color() });
        }
        constexpr std::size_t kMostNamed = 24;
        for (const SurfaceItem& surface : scene.surfaces)
            if (!surface.target && surface.opacity == 1.0 && level_of(surface.name).empty()
                && scene.legend.size() < kMostNamed)
                scene.legend.push_back({ readable(surface.name), " ", surface.look.color });
        // The view from the front, slightly from the patient's left and from above, as a person beside the patient
        // sees.
        const planner::AnatomicalFrame frame = patient.frame();
        const Vec3 sight = -(frame.anterior + 0.45 * frame.left + 0.30 * frame.superior);
        const std::optional<Box> bounds = scene_bounds(scene);
        if (!bounds)
            throw InputError("no label has a surface to draw", "overview");
        scene.camera = camera_for_box(*bounds, sight, frame.superior);
        Picture picture { .width = width, .height = height, .viewports = {} };
        picture.viewports.push_back({ .scene = std::move(scene) });
        return picture;
    }

} // namespace

std::optional<planner::TargetSpec> default_target(planner::Patient& patient)
{
    for (const mesh::Role role : { mesh::Role::target, mesh::Role::at_risk })
        for (const mesh::LabelInfo& info : patient.planned_case().label_table)
            if (info.role == role && patient.has_voxels(info.name))
                return planner::TargetSpec { .label = info.name, .centre = Vec3::Zero() };
    return std::nullopt;
}

Picture case_picture(planner::Patient& patient, const std::optional<planner::TargetSpec>& target, std::string_view view,
    int width, int height)
{
    if (view == "slices")
        return slices_picture(patient, target, width, height);
    if (view == "overview")
        return overview_picture(patient, target, width, height);
    throw InputError("the view \"" + std::string(view)
        + "\" shows a planned approach; without one there are slices and "
          "overview");
}

} // namespace retractor::ui
