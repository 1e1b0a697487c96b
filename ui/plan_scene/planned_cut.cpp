#include "ui/plan_scene/planned_cut.h"

#include "planner/approach/find_division.h"
#include "ui/plan_scene/plan_scene.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

namespace retractor::ui {

namespace {

    constexpr Color kCutRed { 0.85, 0.12, 0.10 };
    constexpr double kCutOpacity = 0.7; ///< the bones that it divides show
    constexpr double kCutTurnDeg = 50.0;

    /// Appends the strip between a line and its copy moved by a depth.
    void add_strip(TriMesh& sheet, const std::vector<Vec3>& line, const std::vector<Vec3>& directions, double depth_mm)
    {
        const Eigen::Index first = sheet.vertices.rows();
        const auto count = static_cast<Eigen::Index>(line.size());
        sheet.vertices.conservativeResize(first + 2 * count, Eigen::NoChange);
        for (Eigen::Index n = 0; n < count; ++n) {
            const Vec3& point = line[static_cast<std::size_t>(n)];
            const Vec3 along = directions[static_cast<std::size_t>(n)].normalized();
            sheet.vertices.row(first + 2 * n) = point.transpose();
            sheet.vertices.row(first + 2 * n + 1) = (point + depth_mm * along).transpose();
        }
        for (Eigen::Index n = 0; n + 1 < count; ++n) {
            const auto at = static_cast<VertexId>(first + 2 * n);
            // Both sides are fronts: what is drawn over everything shows its fronts only.
            sheet.triangles.insert(sheet.triangles.end(),
                { { at, at + 1, at + 2 }, { at + 2, at + 1, at + 3 }, { at, at + 2, at + 1 },
                    { at + 2, at + 3, at + 1 } });
        }
    }

} // namespace

SurfaceItem planned_cut(planner::Patient& patient, planner::Approach approach)
{
    planner::find_division(approach, patient);
    auto sheet = std::make_shared<TriMesh>();
    add_strip(*sheet, approach.incision, approach.directions, approach.depth_mm);
    for (const planner::DivisionStroke& stroke : approach.division.strokes)
        add_strip(*sheet, stroke.line, stroke.directions, stroke.depth_mm);
    return { .name = "planned cut",
        .mesh = std::move(sheet),
        .look = { .color = kCutRed, .finish = Finish::unlit },
        .opacity = kCutOpacity,
        .smooth = false,
        .on_top = true };
}

Camera planned_cut_camera(const Camera& outside, const planner::Approach& approach)
{
    const Vec3 along = (approach.incision.back() - approach.incision.front()).normalized();
    const auto turned = [&](double deg) {
        Camera camera = outside;
        camera.eye
            = outside.aim + Eigen::AngleAxisd(deg * std::numbers::pi / 180.0, along) * (outside.eye - outside.aim);
        return camera;
    };
    const Camera one = turned(kCutTurnDeg), other = turned(-kCutTurnDeg);
    const Vec3 towards(1.0, 0.0, -1.0); // left and feet, LPS
    return towards.dot(one.eye) > towards.dot(other.eye) ? one : other;
}

Scene planned_cut_scene(
    planner::Patient& patient, const planner::Approach& approach, const std::vector<SurfaceItem>& anatomy)
{
    Scene scene = planning_scene(patient, approach);
    for (SurfaceItem& item : scene.surfaces)
        if (item.name == kBodyName)
            item.opacity = kSeeThroughOpacity;
    for (const SurfaceItem& organ : anatomy)
        if (std::ranges::none_of(scene.surfaces, [&](const SurfaceItem& item) { return item.name == organ.name; }))
            scene.surfaces.push_back(organ);
    scene.surfaces.push_back(planned_cut(patient, approach));
    scene.camera = planned_cut_camera(scene.camera, approach);
    return scene;
}

} // namespace retractor::ui
