#include "ui/workstation/planning/incision_tool.h"

#include "planner/case/patient.h"
#include "ui/scene/tissue_colors.h"

#include <QApplication>
#include <QLineF>

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr double kHandleMm = 3.0; ///< radius
    constexpr double kReachPx = 11.0; ///< a press this near to a point takes it
    constexpr double kDragPx = 6.0; ///< a press that moves less is a click
    constexpr double kFreehandEveryMm = 20.0; ///< spacing of the points that a drag over the skin leaves
    constexpr double kLineEveryMm = 3.0; ///< spacing at which the shown line follows the skin
    constexpr double kOffChordMm = 25.0; ///< skin further from the straight line is another part of the body
    constexpr double kLiftMm = 2.0; ///< the coarse skin of the picture must not hide the line
    constexpr double kLineWidthPx = 3.0;
    constexpr Color kEnd { 0.98, 0.80, 0.20 }; ///< the point at which the cut begins

    void append(LiveTopology& all, const TriMesh& mesh, int look)
    {
        const auto first = static_cast<VertexId>(all.rest.rows());
        all.rest.conservativeResize(first + mesh.vertices.rows(), 3);
        all.rest.bottomRows(mesh.vertices.rows()) = mesh.vertices;
        for (const auto& t : mesh.triangles) {
            all.triangles.push_back({ t[0] + first, t[1] + first, t[2] + first });
            all.look_of.push_back(look);
        }
    }

    /// Points of a line, about `spacing_mm` apart, without its beginning and with its end.
    std::vector<Vec3> spaced(const std::vector<Vec3>& line, double spacing_mm)
    {
        double length = 0.0;
        for (std::size_t n = 1; n < line.size(); ++n)
            length += (line[n] - line[n - 1]).norm();
        const int steps = std::max(1, static_cast<int>(std::lround(length / spacing_mm)));
        std::vector<Vec3> points;
        double walked = 0.0;
        for (std::size_t n = 1; n < line.size(); ++n) {
            const double step = (line[n] - line[n - 1]).norm();
            while (static_cast<int>(points.size()) + 1 < steps) {
                const double wanted = length * static_cast<double>(points.size() + 1) / steps;
                if (wanted > walked + step || step == 0.0)
                    break;
                points.emplace_back(line[n - 1] + (wanted - walked) / step * (line[n] - line[n - 1]));
            }
            walked += step;
        }
        points.push_back(line.back());
        return points;
    }

} // namespace

std::vector<vtkProp*> IncisionTool::Props::props() const
{
    std::vector<vtkProp*> all = handles.props();
    const std::vector<vtkProp*> more = line.props();
    all.insert(all.end(), more.begin(), more.end());
    return all;
}

IncisionTool::IncisionTool(PictureView& view)
    : view_(view)
{
}

IncisionTool::~IncisionTool() { end(); }

void IncisionTool::begin(std::vector<Vec3> points, SkinUnder skin_under)
{
    end();
    skin_under_ = std::move(skin_under);
    moving_ = !points.empty();
    points_ = std::move(points);
    lines_.assign(points_.empty() ? 0 : points_.size() - 1, {});
    view_.set_tool(this);
    lay_line(0, points_.size());
    show();
    view_.set_live(&drawn_);
}

void IncisionTool::end()
{
    if (!active())
        return;
    view_.set_live(nullptr);
    view_.set_tool(nullptr);
    skin_under_ = nullptr;
    points_.clear();
    lines_.clear();
    undo_.clear();
    freehand_.clear();
    held_.reset();
    frozen_ = false;
}

bool IncisionTool::undo()
{
    if (undo_.empty() || frozen_)
        return false;
    points_ = std::move(undo_.back());
    undo_.pop_back();
    held_.reset();
    freehand_.clear();
    lay_line(0, points_.size());
    show();
    return true;
}

void IncisionTool::keep_for_undo() { undo_.push_back(points_); }

std::optional<Vec3> IncisionTool::skin_at(const QPointF& at) const
{
    const planner::Ray ray = view_.ray_at(at);
    return skin_under_(ray.origin, ray.direction);
}

std::optional<std::size_t> IncisionTool::handle_at(const QPointF& at) const
{
    std::optional<std::size_t> nearest;
    double reach = kReachPx;
    for (std::size_t n = 0; n < points_.size(); ++n)
        if (const auto place = view_.shown_at(points_[n]); place && QLineF(*place, at).length() <= reach) {
            reach = QLineF(*place, at).length();
            nearest = n;
        }
    return nearest;
}

void IncisionTool::press(const QPointF& at)
{
    if (!view_.is_drawn() || frozen_)
        return;
    const bool again = pressed_.isValid() && pressed_.elapsed() < QApplication::doubleClickInterval()
        && QLineF(at, pressed_at_).length() < kDragPx;
    pressed_.start();
    pressed_at_ = at;
    if (again) {
        pressed_.invalidate();
        if (on_finish)
            on_finish();
        return;
    }
    held_ = handle_at(at);
    if (held_)
        return keep_for_undo();
    if (moving_) {
        if (on_refusal)
            on_refusal("Drag a point of the incision.");
        return;
    }
    const std::optional<Vec3> skin = skin_at(at);
    if (!skin) {
        if (on_refusal)
            on_refusal("There is no skin: click on the patient.");
        return;
    }
    keep_for_undo();
    points_.push_back(*skin);
    freehand_ = { *skin };
    lay_line(points_.size() - 1, points_.size());
    show();
}

void IncisionTool::move(const QPointF& at, bool held)
{
    if (!held || frozen_ || !view_.is_drawn() || QLineF(at, pressed_at_).length() < kDragPx)
        return;
    pressed_.invalidate(); // a drag is no half of a double click
    follow(at);
}

void IncisionTool::follow(const QPointF& at)
{
    const std::optional<Vec3> skin = skin_at(at);
    if (!skin)
        return;
    if (held_) {
        points_[*held_] = *skin;
        lay_line(*held_, *held_ + 1);
    } else if (!freehand_.empty()) {
        freehand_.push_back(*skin);
    }
    show();
}

void IncisionTool::release(const QPointF& at)
{
    if (frozen_)
        return;
    const bool dragged = !pressed_.isValid();
    const bool changed = held_ ? dragged : !freehand_.empty();
    if (held_ && dragged)
        follow(at);
    else if (held_)
        undo_.pop_back(); // nothing has moved
    held_.reset();
    end_freehand();
    if (changed && on_change)
        on_change();
}

void IncisionTool::end_freehand()
{
    if (freehand_.size() > 1)
        for (const Vec3& point : spaced(freehand_, kFreehandEveryMm)) {
            points_.push_back(point);
            lay_line(points_.size() - 1, points_.size());
        }
    freehand_.clear();
    show();
}

std::vector<Vec3> IncisionTool::over_skin(const Vec3& from, const Vec3& to) const
{
    const Vec3 eye = view_.camera().eye;
    const int steps = std::max(1, static_cast<int>(std::lround((to - from).norm() / kLineEveryMm)));
    std::vector<Vec3> line { from };
    for (int n = 1; n < steps; ++n) {
        const Vec3 chord = from + (to - from) * n / steps;
        const auto skin = skin_under_(eye, (chord - eye).normalized());
        const bool near = skin && (*skin - chord).norm() < kOffChordMm;
        line.push_back((near ? *skin : chord) + kLiftMm * (eye - chord).normalized());
    }
    line.push_back(to);
    return line;
}

/// Lays the lines anew beside the points `first` to before `last`.
void IncisionTool::lay_line(std::size_t first, std::size_t last)
{
    lines_.resize(points_.empty() ? 0 : points_.size() - 1);
    if (!view_.is_drawn())
        return;
    for (std::size_t n = first == 0 ? 0 : first - 1; n < std::min(last, lines_.size()); ++n)
        lines_[n] = over_skin(points_[n], points_[n + 1]);
}

void IncisionTool::show()
{
    LiveTopology topology;
    topology.rest.resize(0, 3);
    Look look { .color = incision_color(), .finish = Finish::unlit };
    topology.looks.push_back(look);
    look.color = kEnd;
    topology.looks.push_back(look);
    for (std::size_t n = 0; n < points_.size(); ++n)
        append(topology, planner::sphere_surface(points_[n], kHandleMm), n == 0 ? 1 : 0);
    drawn_.handles.set_topology(topology);
    std::vector<Vec3> line;
    for (const std::vector<Vec3>& piece : lines_)
        line.insert(line.end(), piece.begin(), piece.end());
    line.insert(line.end(), freehand_.begin(), freehand_.end());
    drawn_.line.set_line(line, incision_color(), kLineWidthPx);
    view_.draw_soon();
}

} // namespace retractor::ui
