#include "ui/scene/measurement.h"

#include "mesh/base/text_format.h"
#include "ui/scene/linked_slices.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::ui {

namespace {

    constexpr Color kColor { 1.0, 0.92, 0.35 };
    constexpr double kWidthPx = 2.5;
    constexpr double kLeastArmMm = 1e-6; ///< two places closer than this have no direction

    double angle_deg(const Measurement& measurement)
    {
        const Vec3 a = measurement.places[0] - measurement.places[1], b = measurement.places[2] - measurement.places[1];
        if (a.norm() < kLeastArmMm || b.norm() < kLeastArmMm)
            return 0.0;
        return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0)) * 180.0 / std::numbers::pi;
    }

    Vec3 normal_of(const SliceItem& slice)
    {
        return slice.oblique ? slice.oblique->right.cross(slice.oblique->up)
                             : Vec3(Vec3::Unit(axis_across(slice.plane)));
    }

    /// Whether all places lie in the plane of the slice.
    bool lies_in(const Measurement& measurement, const SliceItem& slice)
    {
        const double reach = 0.5 * (slice.oblique ? slice.image->grid.spacing.minCoeff() : slice_step(slice));
        return std::ranges::all_of(measurement.places,
            [&](const Vec3& place) { return std::abs(normal_of(slice).dot(place - slice.point)) <= reach; });
    }

    /// The measurement in the very plane of the slice, where its lines are not hidden.
    Measurement put_on(Measurement measurement, const SliceItem& slice)
    {
        const Vec3 normal = normal_of(slice);
        for (Vec3& place : measurement.places)
            place -= normal.dot(place - slice.point) * normal;
        return measurement;
    }

    void draw(Scene& scene, const Measurement& measurement, const std::string& text)
    {
        const std::vector<Vec3>& places = measurement.places;
        LineItem line {
            .name = "measurement", .points = places, .color = kColor, .width_px = kWidthPx, .on_top = true
        };
        if (places.size() == 1) {
            scene.words.push_back({ .text = "+", .position = places.front(), .color = kColor });
            return;
        }
        if (measurement.area && places.size() > 2) {
            line.points.push_back(places.front());
            scene.lines.push_back(std::move(line));
            scene.words.push_back({ .text = text, .position = places.back(), .color = kColor });
            return;
        }
        scene.lines.push_back(std::move(line));
        const Vec3 at = places.size() == 2 ? Vec3(0.5 * (places[0] + places[1])) : places[1];
        scene.words.push_back({ .text = text, .position = at, .color = kColor });
    }

} // namespace

double polygon_area_mm2(const std::vector<Vec3>& corners)
{
    Vec3 sum = Vec3::Zero();
    for (std::size_t n = 0; n < corners.size(); ++n)
        sum += (corners[n] - corners.front()).cross(corners[(n + 1) % corners.size()] - corners.front());
    return 0.5 * sum.norm();
}

namespace {

    std::string area_text(const std::vector<Vec3>& corners)
    {
        if (corners.size() < 3)
            return {};
        double round = 0.0;
        for (std::size_t n = 0; n < corners.size(); ++n)
            round += (corners[(n + 1) % corners.size()] - corners[n]).norm();
        return formatted("%.1f cm\u00b2 (perimeter %.0f mm)", polygon_area_mm2(corners) / 100.0, round);
    }

} // namespace

std::string measurement_text(const Measurement& measurement)
{
    const std::vector<Vec3>& places = measurement.places;
    if (measurement.area)
        return area_text(places);
    if (places.size() < 2)
        return {};
    const double first = (places[1] - places[0]).norm();
    if (places.size() == 2)
        return formatted("%.1f mm", first);
    return formatted("%.0f\u00b0 (%.1f and %.1f mm)", angle_deg(measurement), first, (places[2] - places[1]).norm());
}

void draw_measurements(std::vector<Scene>& scenes, const std::vector<Measurement>& measurements)
{
    for (Scene& scene : scenes)
        for (const Measurement& measurement : measurements) {
            const std::string text = measurement_text(measurement);
            if (scene.slices.empty())
                draw(scene, measurement, text);
            else if (scene.slices.size() == 1 && lies_in(measurement, scene.slices.front()))
                draw(scene, put_on(measurement, scene.slices.front()), text);
        }
}

} // namespace retractor::ui
