#pragma once
// What the workstation knows, without a window: the case, which approach is selected, what was planned, what is being
// computed and which scenes are to be shown. No thread and no widget lives here; whoever owns the model asks it for the
// next piece of work, does it elsewhere and delivers the outcome. Used from one thread. Units mm; frame patient LPS.

#include "mesh/base/error.h"
#include "planner/case/case.h"
#include "planner/measures/field_metrics.h"
#include "ui/scene/scene.h"

#include <cstddef>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::ui {

enum class ViewPreset { surgeon, overview, slices };

std::string_view to_string(ViewPreset view);
/// "surgeon", "overview" or "slices".
std::optional<ViewPreset> view_from_string(std::string_view text);

/// An opened field as it is shown: numbers and pictures.
struct FieldPictures {
    planner::FieldMetrics metrics;
    Scene surgeon, overview;
    std::vector<Scene> slices;
    std::string warning; ///< what limits the result, e.g. "not converged"; empty: nothing
};

/// The failure, and in its text the controls that set its fields: " (see Tissue: Model)".
Failure with_controls(Failure failure);

/// Of reading a case: names the file even where the error names only a JSON pointer in it.
Failure case_failure(const std::filesystem::path& file, const Error& error);

enum class FieldStatus {
    closed, ///< not asked for
    waiting, ///< asked for, another one is being planned
    planning,
    cancelling, ///< being planned, but no longer wanted
    planned,
    failed,
};

struct ApproachState {
    FieldStatus status = FieldStatus::closed;
    std::shared_ptr<const Scene> closed; ///< the patient with the incision drawn; null until made
    std::shared_ptr<const FieldPictures> field; ///< null unless planned
    std::optional<Failure> failure; ///< of the plan, or of the closed picture
    bool closed_tried = false; ///< the closed picture was begun
};

/// What is shown, without the scenes themselves: equal when the picture is still the right one.
struct ShownSource {
    std::shared_ptr<const void> pictures; ///< the closed Scene or the FieldPictures; null: nothing yet
    bool opened = false;
    ViewPreset view = ViewPreset::surgeon;
    std::optional<std::size_t> approach;
    bool operator==(const ShownSource&) const = default;
};

class SessionModel {
public:
    /// Selects the first approach, if there is one.
    explicit SessionModel(planner::Case planned_case);

    const planner::Case& planned_case() const { return case_; }
    std::size_t approach_count() const { return states_.size(); }
    const planner::Approach& approach(std::size_t index) const { return case_.approaches.at(index); }
    const ApproachState& state(std::size_t index) const { return states_.at(index); }

    std::optional<std::size_t> selected() const { return selected_; }
    void select(std::size_t index);
    /// @throws InputError naming the approaches there are.
    void select(std::string_view name);

    ViewPreset view() const { return view_; }
    void set_view(ViewPreset view) { view_ = view; }
    /// Slices show a planned field only, and need a CT.
    bool view_available(ViewPreset view) const;

    /// A planned approach can still be looked at as it was before.
    bool show_opened() const { return show_opened_; }
    void set_show_opened(bool opened) { show_opened_ = opened; }

    /// Does nothing when it is planned or on its way.
    void request_plan(std::size_t index);
    /// Withdraws all requests; what is being planned should stop at its next chance.
    void cancel();
    bool busy() const { return planning_.has_value(); }
    std::optional<std::size_t> planning() const { return planning_; }

    /// The approach to plan now; nothing when one is under way or none was asked for.
    std::optional<std::size_t> begin_plan();
    /// Ends of begin_plan(). A result that comes after cancel() is kept: it is right.
    void plan_done(FieldPictures field);
    void plan_cancelled();
    void plan_failed(Failure failure);

    /// The approach whose closed picture is to be made now: the selected one first, then the others.
    std::optional<std::size_t> begin_closed();
    void closed_done(Scene scene);
    void closed_failed(Failure failure);

    ShownSource shown_source() const;
    /// What to draw now; empty while the first picture is being made. Four scenes for the slices: the three
    /// planes and the overview.
    std::vector<Scene> shown_scenes() const;

private:
    planner::Case case_;
    std::vector<ApproachState> states_;
    std::optional<std::size_t> selected_;
    ViewPreset view_ = ViewPreset::surgeon;
    bool show_opened_ = true;
    std::deque<std::size_t> waiting_;
    std::optional<std::size_t> planning_;
    std::optional<std::size_t> making_closed_;
};

/// From where the surgeon will look: along the blade direction at the middle of the incision.
/// @param up the picture's up where it is not along the line of sight.
Camera surgeon_camera(const planner::Approach& approach, const Vec3& up);

} // namespace retractor::ui
