#include "ui/scene/linked_slices.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace retractor::ui {

namespace {

    /// The colours of the planes, as 3D Slicer has them: red axial, green coronal, yellow sagittal.
    Color color_of(SlicePlane plane)
    {
        switch (plane) {
        case SlicePlane::axial:
            return { 0.95, 0.29, 0.20 };
        case SlicePlane::coronal:
            return { 0.43, 0.69, 0.29 };
        case SlicePlane::sagittal:
            break;
        }
        return { 0.93, 0.84, 0.30 };
    }

    Box box_of(const mesh::ImageGrid& grid)
    {
        Box box { Vec3::Constant(std::numeric_limits<double>::max()),
            Vec3::Constant(std::numeric_limits<double>::lowest()) };
        for (int corner = 0; corner < 8; ++corner) {
            Vec3 index;
            for (int axis = 0; axis < 3; ++axis)
                index[axis] = (corner >> axis & 1) != 0 ? grid.size[static_cast<std::size_t>(axis)] - 1 : 0;
            box.low = box.low.cwiseMin(grid.world(index));
            box.high = box.high.cwiseMax(grid.world(index));
        }
        return box;
    }

    /// Where another plane meets this one, from one side of the image to the other.
    LineItem trace_of(SlicePlane other, SlicePlane here, const Vec3& point, const Box& box)
    {
        const int along = 3 - axis_across(other) - axis_across(here);
        LineItem line {
            .name = "plane", .points = { point, point }, .color = color_of(other), .width_px = 1.0, .on_top = true
        };
        line.points[0][along] = box.low[along];
        line.points[1][along] = box.high[along];
        return line;
    }

    /// The outline of a ball in a plane at `at` along an axis, from its outline through the centre; nothing beyond it.
    std::optional<LineItem> ball_outline_at(LineItem circle, int axis, double at)
    {
        Vec3 centre = Vec3::Zero();
        for (std::size_t i = 0; i + 1 < circle.points.size(); ++i) // the last point is the first again
            centre += circle.points[i] / static_cast<double>(circle.points.size() - 1);
        const double radius = (circle.points.front() - centre).norm(), off = at - centre[axis];
        if (std::abs(off) >= radius)
            return std::nullopt;
        const double share = std::sqrt(1.0 - off * off / (radius * radius));
        for (Vec3& p : circle.points) {
            p = centre + share * (p - centre);
            p[axis] = at;
        }
        return circle;
    }

    bool is_ball_outline(const LineItem& line)
    {
        return line.name == "target" && line.points.size() > 3
            && (line.points.front() - line.points.back()).norm() < 1e-6;
    }

    /// The part of a segment that lies near a plane, as fractions of the segment; `from` and `to` are the distances of
    /// its ends from the plane. Nothing where no part does.
    std::optional<std::pair<double, double>> near_part(double from, double to, double near_mm)
    {
        double begin = 0.0, end = 1.0;
        if (from == to)
            return std::abs(from) <= near_mm ? std::optional(std::pair(begin, end)) : std::nullopt;
        const double low = (-near_mm - from) / (to - from), high = (near_mm - from) / (to - from);
        begin = std::max(begin, std::min(low, high));
        end = std::min(end, std::max(low, high));
        return begin < end ? std::optional(std::pair(begin, end)) : std::nullopt;
    }

    /// The parts of a line that lie near the plane at `at` along an axis, put on this plane.
    std::vector<LineItem> parts_near(const LineItem& line, int axis, double at)
    {
        std::vector<LineItem> parts;
        bool goes_on = false;
        for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
            const Vec3 &from = line.points[i], &to = line.points[i + 1];
            const auto near = near_part(from[axis] - at, to[axis] - at, line.near_slice_mm);
            const auto add = [&](double fraction) {
                Vec3 p = from + fraction * (to - from);
                p[axis] = at;
                parts.back().points.push_back(p);
            };
            if (near && !goes_on) {
                parts.push_back(line);
                parts.back().points.clear();
                add(near->first);
            }
            if (near)
                add(near->second);
            goes_on = near && near->second == 1.0;
        }
        return parts;
    }

    /// Lengthens a part that is seen end on, so that it is a dot and not nothing.
    void make_visible(LineItem& part, int axis)
    {
        constexpr double kLeastMm = 3.0;
        const Vec3 middle = 0.5 * (part.points.front() + part.points.back());
        const auto is_far = [&](const Vec3& p) { return (p - middle).norm() >= 0.5 * kLeastMm; };
        if (std::ranges::any_of(part.points, is_far))
            return;
        const Vec3 along = 0.5 * kLeastMm * Vec3::Unit(axis == 0 ? 1 : 0);
        part.points = { middle - along, middle + along };
    }

    /// "LPS 12, -30, 104 mm: 54 HU, aorta"
    std::string probe(const SliceItem& slice, const Vec3& point, const std::map<Label, std::string>& names)
    {
        std::string text = "LPS";
        for (int axis = 0; axis < 3; ++axis)
            text += (axis == 0 ? " " : ", ") + std::to_string(std::lround(point[axis]));
        text += " mm";
        const mesh::ImageGrid& grid = slice.image->grid;
        const Vec3 index = grid.index(point);
        const int i = static_cast<int>(std::lround(index[0])), j = static_cast<int>(std::lround(index[1])),
                  k = static_cast<int>(std::lround(index[2]));
        if (grid.contains(i, j, k))
            text += ": " + std::to_string(slice.image->voxels[grid.offset(i, j, k)]) + " HU";
        if (slice.labels != nullptr)
            if (const auto name = names.find(mesh::label_at(*slice.labels, point)); name != names.end())
                text += ", " + name->second;
        return text;
    }

} // namespace

int axis_across(SlicePlane plane)
{
    switch (plane) {
    case SlicePlane::axial:
        return 2;
    case SlicePlane::coronal:
        return 1;
    case SlicePlane::sagittal:
        break;
    }
    return 0;
}

double slice_step(const SliceItem& slice)
{
    RETRACTOR_ASSERT(slice.image != nullptr);
    Eigen::Index nearest = 0; // the image's axis nearest to the plane's normal
    slice.image->grid.direction.row(axis_across(slice.plane)).cwiseAbs().maxCoeff(&nearest);
    return slice.image->grid.spacing[nearest];
}

Vec3 stepped(const SliceItem& slice, double planes)
{
    const int axis = axis_across(slice.plane);
    const double sign = slice.plane == SlicePlane::coronal ? -1.0 : 1.0; // y points to the back
    const Box box = box_of(slice.image->grid);
    Vec3 point = slice.point;
    point[axis] = std::clamp(point[axis] + sign * planes * slice_step(slice), box.low[axis], box.high[axis]);
    return point;
}

Vec3 place_on_slice(const SliceItem& slice, const Camera& camera, double across, double up, double aspect)
{
    RETRACTOR_ASSERT(camera.parallel);
    const Vec3 sight = (camera.aim - camera.eye).normalized();
    const Vec3 right = sight.cross(camera.up).normalized(), upward = right.cross(sight);
    Vec3 place
        = camera.aim + camera.half_height_mm * ((2.0 * across - 1.0) * aspect * right + (2.0 * up - 1.0) * upward);
    if (slice.oblique) {
        const Vec3 normal = slice.oblique->right.cross(slice.oblique->up);
        return place - normal.dot(place - slice.point) * normal;
    }
    const Box box = box_of(slice.image->grid);
    place = place.cwiseMax(box.low).cwiseMin(box.high);
    const int axis = axis_across(slice.plane);
    place[axis] = slice.point[axis];
    return place;
}

std::vector<LineItem> mark_at(const Vec3& place, double half_length_mm)
{
    std::vector<LineItem> lines;
    for (const SlicePlane plane : { SlicePlane::axial, SlicePlane::coronal, SlicePlane::sagittal }) {
        const Vec3 across = half_length_mm * Vec3::Unit(axis_across(plane));
        lines.push_back({ .name = "mark",
            .points = { place - across, place + across },
            .color = color_of(plane),
            .width_px = 3.0,
            .on_top = true });
    }
    return lines;
}

bool is_linked_slice(const Scene& scene) { return scene.slices.size() == 1 && !scene.slices.front().oblique; }

Scene slice_with_lines(Scene scene, const Vec3& point)
{
    SliceItem& slice = scene.slices.front();
    slice.point = point;
    const int axis = axis_across(slice.plane);
    std::optional<double> incision_within_mm;
    std::vector<LineItem> lines;
    for (const LineItem& line : scene.lines)
        if (is_ball_outline(line)) {
            if (auto outline = ball_outline_at(line, axis, point[axis]))
                lines.push_back(*std::move(outline));
        } else {
            for (LineItem& part : parts_near(line, axis, point[axis])) {
                make_visible(part, axis);
                if (part.name == kIncisionName)
                    incision_within_mm = part.near_slice_mm;
                lines.push_back(std::move(part));
            }
        }
    scene.lines = std::move(lines);
    if (incision_within_mm)
        scene.title += formatted(", incision within %.0f mm", *incision_within_mm);
    return scene;
}

std::vector<Scene> slices_at(std::vector<Scene> scenes, const Vec3& point, const std::map<Label, std::string>& names)
{
    bool has_probe = false;
    for (Scene& scene : scenes) {
        if (!is_linked_slice(scene))
            continue;
        scene = slice_with_lines(std::move(scene), point);
        const SliceItem& slice = scene.slices.front();
        const Box box = box_of(slice.image->grid);
        for (const SlicePlane other : { SlicePlane::axial, SlicePlane::coronal, SlicePlane::sagittal })
            if (other != slice.plane)
                scene.lines.push_back(trace_of(other, slice.plane, point, box));
        if (!has_probe)
            scene.notes.push_back(probe(slice, point, names));
        has_probe = true;
    }
    return scenes;
}

} // namespace retractor::ui
