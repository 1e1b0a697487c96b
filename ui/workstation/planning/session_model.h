#pragma once
// The state of the workstation without a window: the case, the selected approach, the plans, the running work and the
// shown scenes. The model has no thread and no widget. Its owner asks for the next piece of work, does the work
// elsewhere and delivers the outcome. Used from one thread. Units mm; frame patient LPS.

#include "mesh/base/error.h"
#include "planner/case/case.h"
#include "planner/measures/field_metrics.h"
#include "ui/scene/scene.h"

#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::ui {

enum class ViewPreset { surgeon, overview, slices };

/// Reads "surgeon", "overview" or "slices".
std::optional<ViewPreset> view_from_string(std::string_view text);

/// A planned field for the window: numbers and pictures.
struct FieldPictures {
    planner::FieldMetrics metrics;
    Scene surgeon, overview;
    std::string warning; ///< limits of the result, e.g. "not converged"; empty: none
};

/// The patient before any cut.
struct ClosedPictures {
    Scene patient; ///< with the incision
    std::vector<Scene> slices {}; ///< axial, coronal and sagittal; empty without a CT
    std::map<Label, std::string> label_names {};
};

/// Adds the controls that set the failing fields to the text of the failure: " (see Tissue: Model)".
Failure with_controls(Failure failure);

/// A failure to read a case. The text names the file, also where the error names only a JSON pointer.
Failure case_failure(const std::filesystem::path& file, const Error& error);

enum class FieldStatus {
    closed, ///< not requested
    waiting, ///< requested, while another approach is being planned
    planning,
    cancelling, ///< being planned, but no longer requested
    planned,
    failed,
};

struct ApproachState {
    FieldStatus status = FieldStatus::closed;
    std::shared_ptr<const ClosedPictures> closed; ///< null until made
    std::optional<Vec3> slice_point {}; ///< where the slices meet, mm LPS; nothing: as they were made
    std::shared_ptr<const FieldPictures> field; ///< null unless planned
    std::optional<Failure> failure; ///< failure of the plan, or of the closed picture
    bool closed_tried = false; ///< the closed picture was started
};

/// Identifies the shown picture without its scenes. Two equal values mean that the picture is still valid.
struct ShownSource {
    std::shared_ptr<const void> pictures; ///< the ClosedPictures or the FieldPictures; null: nothing yet
    bool opened = false;
    ViewPreset view = ViewPreset::surgeon;
    std::optional<std::size_t> approach;
    std::shared_ptr<const void> slices {}; ///< the ClosedPictures, in the view of slices
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
    /// @throws InputError naming the existing approaches
    void select(std::string_view name);

    ViewPreset view() const { return view_; }
    void set_view(ViewPreset view) { view_ = view; }
    /// Whether the view can be shown: slices need a CT.
    bool view_available(ViewPreset view) const;

    /// Whether a planned approach is shown opened, or as before the cut.
    bool show_opened() const { return show_opened_; }
    void set_show_opened(bool opened) { show_opened_ = opened; }

    /// Does nothing when the approach is planned or waiting.
    void request_plan(std::size_t index);
    /// Withdraws all requests; the running plan stops at its next chance.
    void cancel();
    bool busy() const { return planning_.has_value(); }
    std::optional<std::size_t> planning() const { return planning_; }

    /// The approach to plan now; nothing when a plan is running or nothing was requested.
    std::optional<std::size_t> begin_plan();
    /// The outcomes of begin_plan(). A result after cancel() is kept, because it is correct.
    void plan_done(FieldPictures field);
    void plan_cancelled();
    void plan_failed(Failure failure);

    /// The approach whose closed picture is to be made now: first the selected approach, then the others.
    std::optional<std::size_t> begin_closed();
    void closed_done(ClosedPictures pictures);
    void closed_failed(Failure failure);

    /// @param index of kGreyWindows, for the slices of all approaches
    void set_grey_window(std::size_t index);
    std::size_t grey_window() const { return grey_window_; }
    /// Moves the slices of the selected approach. @pre an approach is selected
    void set_slice_point(const Vec3& point);

    ShownSource shown_source() const;
    /// The scenes to draw now; empty while the first picture is being made. Slices give four scenes: the three planes
    /// and the overview.
    std::vector<Scene> shown_scenes() const;

private:
    planner::Case case_;
    std::vector<ApproachState> states_;
    std::optional<std::size_t> selected_;
    ViewPreset view_ = ViewPreset::surgeon;
    bool show_opened_ = true;
    std::size_t grey_window_ = 0;
    std::deque<std::size_t> waiting_;
    std::optional<std::size_t> planning_;
    std::optional<std::size_t> making_closed_;
};

/// The camera of the surgeon: along the blade direction at the middle of the incision.
/// @param up up vector of the picture, unless parallel to the line of sight
Camera surgeon_camera(const planner::Approach& approach, const Vec3& up);

} // namespace retractor::ui
