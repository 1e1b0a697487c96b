#include "ui/workstation/planning/session_model.h"

#include "mesh/base/assert.h"
#include "ui/scene/linked_slices.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace retractor::ui {

namespace {

    /// A field of a request (see Error::fields()) and the control for it.
    struct FieldControl {
        std::string_view field, control;
    };

    constexpr std::array kFieldControls {
        FieldControl { "model", "Tissue: Model" },
        FieldControl { "structure", "File: Palpate a structure…" },
    };

    /// The controls for the fields, " (see Tissue: Model)"; empty when no control sets any of them.
    std::string control_hint(const std::vector<std::string>& fields)
    {
        std::string controls;
        for (const std::string& field : fields)
            for (const FieldControl& entry : kFieldControls)
                if (entry.field == field)
                    controls += (controls.empty() ? "" : ", ") + std::string(entry.control);
        return controls.empty() ? std::string() : " (see " + controls + ")";
    }

    /// Point and unit blade direction at half the length of the incision.
    std::pair<Vec3, Vec3> incision_middle(const planner::Approach& approach)
    {
        const double half = planner::incision_length(approach) / 2.0;
        double walked = 0.0;
        for (std::size_t i = 0; i + 1 < approach.incision.size(); ++i) {
            const double step = (approach.incision[i + 1] - approach.incision[i]).norm();
            if (walked + step >= half && step > 0.0) {
                const double t = (half - walked) / step;
                return { (1.0 - t) * approach.incision[i] + t * approach.incision[i + 1],
                    ((1.0 - t) * approach.directions[i] + t * approach.directions[i + 1]).normalized() };
            }
            walked += step;
        }
        return { approach.incision.back(), approach.directions.back().normalized() };
    }

} // namespace

std::optional<ViewPreset> view_from_string(std::string_view text)
{
    if (text == "surgeon")
        return ViewPreset::surgeon;
    if (text == "overview")
        return ViewPreset::overview;
    return text == "slices" ? std::optional(ViewPreset::slices) : std::nullopt;
}

Failure with_controls(Failure failure)
{
    failure.what += control_hint(failure.fields);
    return failure;
}

Failure case_failure(const std::filesystem::path& file, const Error& error)
{
    const std::string name = file.string();
    if (error.where().find(name) != std::string::npos)
        return { error.what(), error.where() };
    return { error.what(), error.where().empty() ? name : name + ": " + error.where() };
}

SessionModel::SessionModel(planner::Case planned_case)
    : case_(std::move(planned_case))
    , states_(case_.approaches.size())
{
    if (!states_.empty())
        selected_ = 0;
}

void SessionModel::select(std::size_t index)
{
    RETRACTOR_ASSERT(index < states_.size());
    selected_ = index;
}

void SessionModel::select(std::string_view name)
{
    const planner::Approach& found = planner::find_approach(case_, name);
    select(static_cast<std::size_t>(&found - case_.approaches.data()));
}

bool SessionModel::view_available(ViewPreset view) const
{
    if (!selected_)
        return false;
    const auto& closed = states_[*selected_].closed;
    if (view != ViewPreset::slices)
        return true;
    return closed != nullptr ? !closed->slices.empty() : case_.ct.has_value();
}

void SessionModel::request_plan(std::size_t index)
{
    ApproachState& state = states_.at(index);
    if (state.status != FieldStatus::closed && state.status != FieldStatus::failed)
        return;
    state.status = FieldStatus::waiting;
    state.failure.reset();
    waiting_.push_back(index);
}

void SessionModel::cancel()
{
    RETRACTOR_ASSERT(!planning_ || *planning_ < states_.size());
    for (const std::size_t index : waiting_)
        states_[index].status = FieldStatus::closed;
    waiting_.clear();
    if (planning_)
        states_[*planning_].status = FieldStatus::cancelling;
}

std::optional<std::size_t> SessionModel::begin_plan()
{
    if (planning_ || waiting_.empty())
        return std::nullopt;
    RETRACTOR_ASSERT(waiting_.front() < states_.size());
    planning_ = waiting_.front();
    waiting_.pop_front();
    states_[*planning_].status = FieldStatus::planning;
    return planning_;
}

void SessionModel::plan_done(FieldPictures field)
{
    RETRACTOR_ASSERT(planning_);
    ApproachState& state = states_[*std::exchange(planning_, std::nullopt)];
    state.field = std::make_shared<const FieldPictures>(std::move(field));
    state.status = FieldStatus::planned;
}

void SessionModel::plan_cancelled()
{
    RETRACTOR_ASSERT(planning_);
    states_[*std::exchange(planning_, std::nullopt)].status = FieldStatus::closed;
}

void SessionModel::plan_failed(Failure failure)
{
    RETRACTOR_ASSERT(planning_);
    ApproachState& state = states_[*std::exchange(planning_, std::nullopt)];
    state.failure = std::move(failure);
    state.status = FieldStatus::failed;
}

std::optional<std::size_t> SessionModel::begin_closed()
{
    if (making_closed_ || !selected_)
        return std::nullopt;
    const auto open = [&](std::size_t index) { return !states_[index].closed_tried; };
    for (std::size_t i = 0; i < states_.size(); ++i) {
        const std::size_t index = (*selected_ + i) % states_.size();
        if (open(index)) {
            states_[index].closed_tried = true;
            making_closed_ = index;
            return making_closed_;
        }
    }
    return std::nullopt;
}

void SessionModel::closed_done(ClosedPictures pictures)
{
    RETRACTOR_ASSERT(making_closed_);
    states_[*std::exchange(making_closed_, std::nullopt)].closed
        = std::make_shared<const ClosedPictures>(std::move(pictures));
}

void SessionModel::closed_failed(Failure failure)
{
    RETRACTOR_ASSERT(making_closed_);
    states_[*std::exchange(making_closed_, std::nullopt)].failure = std::move(failure);
}

void SessionModel::set_grey_window(std::size_t index)
{
    RETRACTOR_ASSERT(index < kGreyWindows.size());
    grey_window_ = index;
}

void SessionModel::set_slice_point(const Vec3& point)
{
    RETRACTOR_ASSERT(selected_);
    states_[*selected_].slice_point = point;
}

ShownSource SessionModel::shown_source() const
{
    if (!selected_)
        return {};
    RETRACTOR_ASSERT(*selected_ < states_.size());
    const ApproachState& state = states_[*selected_];
    const bool opened
        = state.field != nullptr && (show_opened_ || view_ == ViewPreset::slices || state.closed == nullptr);
    ShownSource source { .pictures = nullptr, .opened = opened, .view = view_, .approach = selected_ };
    if (opened)
        source.pictures = state.field;
    else
        source.pictures = state.closed;
    if (view_ == ViewPreset::slices)
        source.slices = state.closed;
    return source;
}

std::vector<Scene> SessionModel::shown_scenes() const
{
    const ShownSource source = shown_source();
    if (source.pictures == nullptr)
        return {};
    const ApproachState& state = states_[*selected_];
    const Scene& overview = source.opened ? state.field->overview : state.closed->patient;
    if (view_ == ViewPreset::slices && state.closed != nullptr && !state.closed->slices.empty()) {
        const std::vector<Scene>& slices = state.closed->slices;
        std::vector<Scene> scenes = slices_at(
            slices, state.slice_point.value_or(slices.front().slices.front().point), state.closed->label_names);
        for (Scene& scene : scenes)
            for (SliceItem& slice : scene.slices) {
                slice.window_hu = kGreyWindows[grey_window_].window_hu;
                slice.level_hu = kGreyWindows[grey_window_].level_hu;
            }
        scenes.push_back(overview);
        return scenes;
    }
    if (source.opened)
        return { view_ == ViewPreset::surgeon ? state.field->surgeon : overview };
    Scene scene = overview;
    if (view_ == ViewPreset::surgeon)
        scene.camera = surgeon_camera(case_.approaches[*selected_], scene.camera.up);
    return { std::move(scene) };
}

Camera surgeon_camera(const planner::Approach& approach, const Vec3& up)
{
    // The incision fills about half of the picture's height, so that the body round it shows its place.
    constexpr double kHeightPerLength = 2.0;
    constexpr double kSmallestHeightMm = 120.0;
    const auto [middle, into] = incision_middle(approach);
    Camera camera;
    camera.eye = middle - approach.view.eye_distance_mm * into;
    camera.aim = middle;
    const double height = std::max(kSmallestHeightMm, kHeightPerLength * planner::incision_length(approach));
    camera.view_angle_deg = 2.0 * std::atan(height / 2.0 / approach.view.eye_distance_mm) * 180.0 / std::numbers::pi;
    camera.up = (up - up.dot(into) * into);
    // In a view along `up` the vector has no use, and the head serves instead.
    if (camera.up.norm() < 0.05 * up.norm())
        camera.up = into.unitOrthogonal();
    camera.up.normalize();
    return camera;
}

} // namespace retractor::ui
