#include "ui/workstation/palpation/touch_tool.h"

#include "mesh/surface/surface_normals.h"

#include <algorithm>
#include <utility>

namespace retractor::ui {

namespace {

    /// Distance between the tissue and a fingertip that does not press, as a share of its radius.
    constexpr double kHoverShare = 0.5;
    /// Step per notch of the wheel, as a share of the radius: 0.25 mm for 4 mm.
    constexpr double kNotchShare = 1.0 / 16.0;
    constexpr double kFarAway = 400.0; // mm

} // namespace

TouchTool::TouchTool(PictureView& view)
    : view_(view)
{
}

TouchTool::~TouchTool() { view_.set_tool(nullptr); }

void TouchTool::touch(planner::PalpationWorker* worker, std::size_t fingers, double radius)
{
    worker_ = worker;
    fingers_ = worker != nullptr ? fingers : 0;
    radius_ = radius;
    finger_ = 0;
    held_ = false;
    asked_ = nullptr;
    view_.set_tool(worker != nullptr ? this : nullptr);
    if (worker == nullptr)
        surface_.reset();
    lift_all();
}

void TouchTool::set_surface(std::shared_ptr<const TriMesh> surface)
{
    surface_ = std::move(surface);
    normals_ = mesh::vertex_normals(*surface_);
    away_ = surface_->vertices.colwise().maxCoeff().transpose().array() + kFarAway;
    for (std::size_t f = 0; f < planner::kMostFingers; ++f)
        if (!hands_[f].at)
            put(f, true);
}

void TouchTool::changed() const
{
    if (on_change)
        on_change();
}

std::optional<planner::SurfacePlace> TouchTool::under(const QPointF& at) const
{
    if (surface_ == nullptr || !view_.is_drawn())
        return std::nullopt;
    return planner::place_under(*surface_, normals_, view_.ray_at(at));
}

/// Tells the finger's device its present place.
void TouchTool::put(std::size_t finger, bool hops)
{
    if (worker_ == nullptr)
        return;
    const Hand& hand = hands_[finger];
    haptics::PointerDevice& pointer = worker_->pointer(finger);
    if (!hand.at)
        return pointer.hop_to(away_);
    const double height = radius_ + (hand.pressed ? -hand.depth : kHoverShare * radius_);
    const Vec3 place = hand.at->point + height * hand.at->outward;
    if (hops)
        pointer.hop_to(place);
    else
        pointer.point_at(place);
}

void TouchTool::set_depth(double mm)
{
    depth_ = std::clamp(mm, 0.0, deepest());
    if (Hand& hand = hands_[finger_]; hand.pressed) {
        hand.depth = depth_;
        put(finger_, false);
    }
    changed();
}

void TouchTool::take_finger(std::size_t finger)
{
    if (finger >= fingers_ || finger == finger_)
        return;
    // A finger that does not press hovers at the mouse, and goes away.
    if (Hand& left = hands_[finger_]; !left.pressed) {
        left.at.reset();
        put(finger_, true);
    }
    finger_ = finger;
    changed();
}

void TouchTool::lift_all()
{
    for (std::size_t f = 0; f < planner::kMostFingers; ++f) {
        hands_[f] = {};
        put(f, true);
    }
    changed();
}

void TouchTool::press(const QPointF& at)
{
    const auto place = under(at);
    if (!place) {
        if (on_refused)
            on_refused("there is no tissue under the mouse");
        return;
    }
    if (const auto answer = std::exchange(asked_, nullptr))
        return answer(*place);
    held_ = true;
    // The finger first moves above the place, from wherever it is. It lets go of the earlier press and sweeps nothing
    // aside on the way.
    hands_[finger_] = { place, false, 0.0 };
    put(finger_, true);
    hands_[finger_] = { place, true, depth_ };
    put(finger_, false);
    changed();
}

void TouchTool::move(const QPointF& at, bool held)
{
    Hand& hand = hands_[finger_];
    if (hand.pressed && !(held && held_))
        return; // the finger stays pressed
    const auto place = under(at);
    if (!place && hand.pressed)
        return;
    const bool came = place.has_value() != hand.at.has_value();
    hand.at = place;
    put(finger_, !hand.pressed);
    if (came)
        changed();
}

void TouchTool::release(const QPointF&)
{
    // When another finger was taken since the press, the finger that pressed stays.
    if (Hand& hand = hands_[finger_]; std::exchange(held_, false) && hand.pressed) {
        hand.pressed = false;
        put(finger_, false);
        changed();
    }
}

bool TouchTool::wheel(const QPointF&, double notches)
{
    if (!held_)
        return false;
    set_depth(depth_ + notches * kNotchShare * radius_);
    return true;
}

} // namespace retractor::ui
