#include "ui/plan_scene/vessel_surfaces.h"

#include "planner/anatomy/assumed_vessels.h"
#include "ui/scene/tissue_colors.h"
#include "ui/scene/vtk/tube.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr Color kArtery { 0.80, 0.08, 0.08 }, kBundle { 0.93, 0.78, 0.22 };
    constexpr double kStepMm = 2.0; ///< between places of a vessel that follow the tissue
    constexpr double kNearIncisionMm = 60.0;
    /// Tissue farther from a vessel than this does not carry it.
    constexpr double kCarriedMm = 12.0;
    /// A piece of a vessel that becomes so many times as long bridges the wound: it is divided.
    constexpr double kTornStretch = 3.0;

    Color color_of(const planner::AssumedVessel& vessel)
    {
        return planner::is_neurovascular_bundle(vessel.name) ? kBundle : kArtery;
    }

    SurfaceItem item_of(const planner::AssumedVessel& vessel, const std::vector<Vec3>& line)
    {
        SurfaceItem item;
        item.name = vessel.name + std::string(kAssumed);
        item.mesh = std::make_shared<const TriMesh>(tube(line, vessel.radius_mm));
        item.look = tissue_look("vessel");
        item.look.color = color_of(vessel);
        return item;
    }

    bool is_near(const std::vector<Vec3>& places, const std::vector<Vec3>& incision)
    {
        return std::ranges::any_of(places, [&](const Vec3& p) {
            return std::ranges::any_of(incision, [&](const Vec3& q) { return (p - q).norm() < kNearIncisionMm; });
        });
    }

    /// The motion of the wall's vertex that is nearest to a place at rest; none far from the wall.
    Vec3 motion_at(const Vec3& place, const planner::PlannedField& field)
    {
        Eigen::Index nearest = 0;
        const double squared
            = (field.wall.vertices.rowwise() - place.transpose()).rowwise().squaredNorm().minCoeff(&nearest);
        if (field.opening.displacement.rows() != field.wall.vertices.rows() || !(squared < kCarriedMm * kCarriedMm))
            return Vec3::Zero();
        return field.opening.displacement.row(nearest).transpose();
    }

} // namespace

std::vector<SurfaceItem> vessel_surfaces(const planner::Case& planned_case)
{
    std::vector<SurfaceItem> items;
    for (const planner::AssumedVessel& vessel : planned_case.assumed_vessels)
        items.push_back(item_of(vessel, vessel.line));
    return items;
}

std::vector<SurfaceItem> vessel_surfaces(const planner::Case& planned_case, const planner::PlannedField& field)
{
    std::vector<SurfaceItem> items;
    for (const planner::AssumedVessel& vessel : planned_case.assumed_vessels) {
        const std::vector<Vec3> places = planner::places_along(vessel, kStepMm);
        if (!is_near(places, field.approach.incision))
            continue;
        std::vector<std::vector<Vec3>> pieces(1);
        for (std::size_t n = 0; n < places.size(); ++n) {
            const Vec3 moved = places[n] + motion_at(places[n], field);
            if (n > 0 && (moved - pieces.back().back()).norm() > kTornStretch * (places[n] - places[n - 1]).norm())
                pieces.emplace_back();
            pieces.back().push_back(moved);
        }
        for (const std::vector<Vec3>& piece : pieces)
            if (piece.size() >= 2)
                items.push_back(item_of(vessel, piece));
    }
    return items;
}

std::vector<LineItem> vessel_lines(const planner::Case& planned_case)
{
    constexpr double kNearSliceMm = 2.5, kWidthPx = 8.0;
    std::vector<LineItem> lines;
    for (const planner::AssumedVessel& vessel : planned_case.assumed_vessels)
        lines.push_back({ .name = vessel.name + std::string(kAssumed),
            .points = vessel.line,
            .color = color_of(vessel),
            .width_px = kWidthPx,
            .on_top = true,
            .near_slice_mm = kNearSliceMm });
    return lines;
}

void remove_vessels(Scene& scene)
{
    std::erase_if(scene.surfaces, [](const SurfaceItem& item) { return item.name.ends_with(kAssumed); });
}

} // namespace retractor::ui
