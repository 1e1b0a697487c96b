#include "ui/plan_scene/port_picture.h"

#include "mesh/base/text_format.h"
#include "planner/search/aperture_score.h"
#include "ui/scene/tissue_colors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr Color kScopeColor { 0.20, 0.55, 1.00 };
    constexpr std::array<Color, 2> kShaftColors { { { 1.00, 0.75, 0.15 }, { 0.95, 0.35, 0.85 } } };

    planner::Approach organs_of(planner::Patient& patient, const planner::PortRequest& request)
    {
        planner::Approach approach;
        approach.target = request.target;
        approach.retracted = planner::organs_aside(patient.planned_case().label_table, request.target,
            request.left ? planner::ApertureKind::left_space : planner::ApertureKind::right_space, request.aside);
        return approach;
    }

    SurfaceItem target_item(planner::Patient& patient, const planner::TargetSpec& target)
    {
        return { .name = readable(planner::target_name(target)),
            .mesh = patient.target(target),
            .look = Look { .color = target_color() },
            .target = true };
    }

    void add_organs(Scene& scene, planner::Patient& patient, const planner::PortRequest& request)
    {
        const planner::Approach approach = organs_of(patient, request);
        for (const mesh::LabelInfo& info : patient.planned_case().label_table)
            if (info.name != request.target.label && planner::stays_in_place(info, approach, patient))
                scene.surfaces.push_back({ .name = readable(info.name),
                    .mesh = patient.organ(info.name),
                    .look = organ_look(info.name, info.material) });
    }

    LineItem shaft_line(const std::string& name, const Vec3& tip, const Vec3& skin, double outside_mm, Color color)
    {
        return { .name = name,
            .points = { tip, skin + outside_mm * (skin - tip).normalized() },
            .color = color,
            .width_px = 6.0,
            .on_top = true };
    }

    Scene outside(planner::Patient& patient, const planner::PortRequest& request, const planner::PortPlan& plan)
    {
        constexpr double kClearSkin = 0.35, kShownOutsideMm = 120.0;
        Scene scene;
        scene.title = "ports";
        scene.surfaces.push_back(
            { .name = "body", .mesh = patient.body(), .look = tissue_look("skin"), .opacity = kClearSkin });
        scene.surfaces.push_back(target_item(patient, request.target));
        scene.lines.push_back(shaft_line("scope", plan.view.tip, plan.scope.skin, kShownOutsideMm, kScopeColor));
        scene.legend.push_back({ "scope: " + planner::place_in_words(plan.scope), {}, kScopeColor });
        for (std::size_t n = 0; n < plan.instruments.size(); ++n) {
            const planner::Port& port = plan.instruments.at(n);
            scene.lines.push_back(shaft_line(
                "instrument " + std::to_string(n + 1), plan.middle, port.skin, kShownOutsideMm, kShaftColors.at(n)));
            scene.legend.push_back({ "instrument: " + planner::place_in_words(port), {}, kShaftColors.at(n) });
        }
        scene.legend_share = 0.6;
        const planner::AnatomicalFrame frame = patient.frame();
        const Vec3 side = request.left ? frame.left : Vec3(-frame.left);
        const std::optional<Box> bounds = scene_bounds(scene);
        scene.camera = camera_for_box(bounds.value(), -(0.8 * frame.anterior + side).normalized(), frame.superior);
        return scene;
    }

    Scene through_scope(planner::Patient& patient, const planner::PortRequest& request, const planner::PortPlan& plan)
    {
        Scene scene;
        scene.title = formatted("the scope's picture, %.0f degree optics", request.optics.tilt_deg);
        scene.surfaces.push_back({ .name = "chest wall", .mesh = patient.body(), .look = tissue_look("muscle") });
        scene.surfaces.push_back(target_item(patient, request.target));
        add_organs(scene, patient, request);
        const Vec3& up = patient.frame().superior;
        scene.camera = { .eye = plan.view.tip,
            .aim = plan.view.tip + plan.view.to_target_mm * plan.view.view,
            .up = std::abs(up.dot(plan.view.view)) > 0.95 ? patient.frame().anterior : up,
            .view_angle_deg = request.optics.field_deg };
        return scene;
    }

} // namespace

Picture port_picture(planner::Patient& patient, const planner::PortRequest& request, const planner::PortPlan& plan,
    int width, int height)
{
    Picture picture { .width = width, .height = height, .viewports = {} };
    picture.viewports.push_back({ .left = 0.0, .right = 0.5, .scene = outside(patient, request, plan) });
    picture.viewports.push_back({ .left = 0.5, .right = 1.0, .scene = through_scope(patient, request, plan) });
    return picture;
}

} // namespace retractor::ui
