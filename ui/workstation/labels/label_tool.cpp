#include "ui/workstation/labels/label_tool.h"

#include "mesh/base/error.h"
#include "mesh/image/skeleton.h"
#include "ui/scene/linked_slices.h"

#include <cmath>
#include <cstddef>

namespace retractor::ui {

mesh::LabelFlags kept_by(const LabelBrushState& state, const mesh::LabelTable& table)
{
    const mesh::LabelInfo* painted = mesh::find_label(table, state.label);
    const bool paints_bone = painted != nullptr && mesh::is_skeleton(*painted);
    return mesh::flagged_labels(table,
        [&](const mesh::LabelInfo& info) { return state.keeps_bone && !paints_bone && mesh::is_skeleton(info); });
}

datasets::LabelEdit LabelTool::edit_of(const mesh::LabelVolume& labels) const
{
    // Paint adds to what the stroke did; what is erased depends on the whole way.
    const bool whole = state_.brush == LabelBrush::erase;
    const datasets::BrushStroke stroke {
        .path = whole || path_.size() < 2 ? path_ : std::vector<Vec3>(path_.end() - 2, path_.end()),
        .radius_mm = state_.radius_mm,
        .normal = state_.ball ? std::nullopt : std::optional(normal_),
    };
    switch (state_.brush) {
    case LabelBrush::paint:
        return datasets::painted(labels, stroke, state_.label, kept_by(state_, labels.table));
    case LabelBrush::erase:
        return datasets::erased(labels, stroke, state_.label);
    case LabelBrush::fill:
        break;
    }
    if (kept_by(state_, labels.table)[mesh::label_at(labels, path_.back())] != 0)
        throw InputError("This is bone. Take the tick off Keep bones to fill it.");
    return datasets::region_filled(labels, path_.back(), normal_, state_.label);
}

void LabelTool::stroke_to(const Vec3& place)
{
    using Part = planner::LabelSession::Part;
    path_.push_back(place);
    try {
        const Part next = state_.brush == LabelBrush::erase ? Part::instead : Part::more;
        const bool changed = session_->edit(
            [&](const mesh::LabelVolume& labels) { return edit_of(labels); }, began_ ? next : Part::first);
        began_ = began_ || changed;
        if (changed)
            on_edit();
    } catch (const Error& error) {
        on_refusal(QString::fromStdString(error.what()));
    }
}

void LabelTool::press(const QPointF& at)
{
    path_.clear();
    began_ = false;
    if (session_ == nullptr)
        return;
    const auto place = view_.slice_place_at(at);
    const auto plane = view_.slice_plane_at(at);
    if (!place || !plane)
        return on_refusal("Paint on a slice.");
    if (state_.label == 0)
        return on_refusal("Choose a label in the list first.");
    normal_ = Vec3::Unit(axis_across(*plane));
    stroke_to(*place);
}

void LabelTool::move(const QPointF& at, bool held)
{
    constexpr double kSameSliceMm = 1e-6;
    show_size(at);
    if (!held || path_.empty() || session_ == nullptr || state_.brush == LabelBrush::fill)
        return;
    const auto plane = view_.slice_plane_at(at);
    const auto place = view_.slice_place_at(at);
    if (!place || !plane || Vec3::Unit(axis_across(*plane)) != normal_)
        return;
    if (std::abs((*place - path_.back()).dot(normal_)) > kSameSliceMm) { // the wheel has turned the slice
        path_.clear();
        began_ = false;
    }
    stroke_to(*place);
}

void LabelTool::release(const QPointF&)
{
    if (state_.brush == LabelBrush::erase && began_ && session_ != nullptr && on_unlabelled)
        if (const std::size_t count = session_->unlabelled_by_last(); count > 0)
            on_unlabelled(count);
    path_.clear();
    began_ = false;
}

void LabelTool::show_size(const QPointF& at)
{
    constexpr double kStepPx = 10.0;
    const auto here = view_.slice_place_at(at), beside = view_.slice_place_at(at + QPointF(kStepPx, 0.0));
    if (!here || !beside || state_.brush == LabelBrush::fill)
        return on_size(0.0);
    const double mm = (*beside - *here).norm();
    on_size(mm > 0.0 ? 2.0 * state_.radius_mm * kStepPx / mm : 0.0);
}

} // namespace retractor::ui
