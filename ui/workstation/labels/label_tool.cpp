#include "ui/workstation/labels/label_tool.h"

#include "mesh/base/error.h"
#include "mesh/image/skeleton.h"
#include "ui/scene/linked_slices.h"

namespace retractor::ui {

namespace {

    mesh::LabelFlags kept_by(const LabelBrushState& state, const mesh::LabelTable& table)
    {
        const mesh::LabelInfo* painted = mesh::find_label(table, state.label);
        const bool paints_bone = painted != nullptr && mesh::is_skeleton(*painted);
        return mesh::flagged_labels(table, [&](const mesh::LabelInfo& info) {
            return state.keeps_bone && !paints_bone && mesh::is_skeleton(info);
        });
    }

} // namespace

void LabelTool::stroke_to(const Vec3& place, bool goes_on)
{
    const datasets::BrushStroke stroke {
        .path = last_ && goes_on ? std::vector<Vec3> { *last_, place } : std::vector<Vec3> { place },
        .radius_mm = state_.radius_mm,
        .normal = state_.ball ? std::nullopt : std::optional(normal_),
    };
    last_ = place;
    try {
        const bool changed = session_->edit(
            [&](const mesh::LabelVolume& labels) {
                switch (state_.brush) {
                case LabelBrush::paint:
                    return datasets::painted(labels, stroke, state_.label, kept_by(state_, labels.table));
                case LabelBrush::erase:
                    return datasets::erased(labels, stroke, state_.label);
                case LabelBrush::fill:
                    break;
                }
                return datasets::region_filled(labels, place, normal_, state_.label);
            },
            began_);
        began_ = began_ || changed;
        if (changed)
            on_edit();
    } catch (const Error& error) {
        on_refusal(QString::fromStdString(error.what()));
    }
}

void LabelTool::press(const QPointF& at)
{
    last_.reset();
    began_ = false;
    if (session_ == nullptr)
        return;
    const auto place = view_.slice_place_at(at);
    const auto plane = view_.slice_plane_at(at);
    if (!place || !plane)
        return on_refusal("Paint on a slice.");
    normal_ = Vec3::Unit(axis_across(*plane));
    stroke_to(*place, false);
}

void LabelTool::move(const QPointF& at, bool held)
{
    show_size(at);
    if (!held || !last_ || session_ == nullptr || state_.brush == LabelBrush::fill)
        return;
    const auto plane = view_.slice_plane_at(at);
    const auto place = view_.slice_place_at(at);
    if (place && plane && Vec3::Unit(axis_across(*plane)) == normal_)
        stroke_to(*place, true);
}

void LabelTool::release(const QPointF&)
{
    last_.reset();
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
