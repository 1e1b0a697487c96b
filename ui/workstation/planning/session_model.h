#pragma once
// The state of the workstation without a window: the case, the selected approach, the edits, the plans, the running
// work and the shown scenes. The model has no thread and no widget. Its owner asks for the next piece of work, does the
// work elsewhere and delivers the outcome. Used from one thread. Units mm; frame patient LPS.

#include "mesh/base/error.h"
#include "planner/case/case.h"
#include "planner/decision/decisions.h"
#include "planner/measures/field_metrics.h"
#include "planner/measures/ranking.h"
#include "ui/plan_scene/field_map.h"
#include "ui/scene/measurement.h"
#include "ui/scene/pick.h"
#include "ui/scene/scene.h"

#include <cstddef>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace retractor::ui {

enum class ViewPreset {
    surgeon,
    overview,
    slices,
    incision,
    compare, ///< the surgeon's view of planned approaches beside each other
};

/// How labels are drawn on slices.
enum class LabelLook { filled, outlined, hidden };

/// How the body's wall is drawn in space.
enum class WallLook { solid, see_through, hidden };

/// The part of the patient that is cut away in space.
enum class CutSide { front, back, left, right, head, feet };

/// Whether the view shows slices of the CT: three planes, or the planes along and across the incision.
inline bool shows_slices(ViewPreset view) { return view == ViewPreset::slices || view == ViewPreset::incision; }

/// Whether an incision can be drawn in the view: on one picture of the patient in space.
inline bool is_drawn_on(ViewPreset view) { return view == ViewPreset::surgeon || view == ViewPreset::overview; }

/// Reads "surgeon", "overview", "slices", "incision" or "compare".
std::optional<ViewPreset> view_from_string(std::string_view text);

/// A planned field for the window: numbers and pictures.
struct FieldPictures {
    planner::FieldMetrics metrics;
    std::vector<std::string> divided_bones {}; ///< see planner::divided_bones()
    Scene surgeon {}, overview {};
    std::map<FieldMapKind, SceneMap> maps {}; ///< numbers of the field as colours
    std::string warning; ///< limits of the result, e.g. "not converged"; empty: none
};

/// The patient before any cut.
struct ClosedPictures {
    Scene patient; ///< with the incision
    std::vector<Scene> slices {}; ///< axial, coronal and sagittal; empty without a CT
    std::vector<Scene> incision_slices {}; ///< along and across the incision; empty without a CT or an incision
    std::optional<SurfaceItem> cut {}; ///< seen through the wall; nothing without an incision
    std::map<Label, std::string> label_names {};
    /// The place of the skin that a ray from outside the body meets first, if any. Arguments: start and unit direction.
    std::function<std::optional<Vec3>(const Vec3&, const Vec3&)> skin_under {};
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
    bool saved_tried = false; ///< a plan of an earlier session was looked for
    bool as_draft = false; ///< what is asked for, being planned or planned is a draft
    /// What the approach was called when its pictures may have been made, where it was renamed since.
    std::vector<std::string> former_names {};
};

/// Identifies the shown picture without its scenes. Two equal values mean that the picture is still valid.
struct ShownSource {
    std::shared_ptr<const void> pictures; ///< the ClosedPictures or the FieldPictures; null: nothing yet
    bool opened = false;
    ViewPreset view = ViewPreset::surgeon;
    std::optional<std::size_t> approach; ///< its id
    std::string name {}; ///< of the approach, for people
    std::shared_ptr<const void> slices {}; ///< the ClosedPictures, in the view of slices
    std::vector<std::shared_ptr<const void>> compared {}; ///< the FieldPictures, in a comparison
    std::optional<std::size_t> alone {}; ///< the picture of several that fills the view
    std::optional<FieldMapKind> map {}; ///< drawn on the opened field
    bool operator==(const ShownSource&) const = default;
};

/// The work of drawing one closed picture.
struct ClosedWork {
    std::optional<planner::Approach> approach; ///< nothing: the patient alone
};

/// Approaches are named by their index in the list. An approach keeps its id when others come and go, and when only its
/// title changes. An approach that is changed otherwise has a new id, because pictures and plans of the old one do not
/// show it.
class SessionModel {
public:
    /// Selects the first approach, if there is one.
    explicit SessionModel(planner::Case planned_case);

    /// The case with its present approaches.
    const planner::Case& planned_case() const { return case_; }
    std::size_t approach_count() const { return ids_.size(); }
    const planner::Approach& approach(std::size_t index) const { return case_.approaches.at(index); }
    const ApproachState& state(std::size_t index) const { return states_.at(ids_.at(index)); }
    std::size_t id(std::size_t index) const { return ids_.at(index); }

    /// Nothing: there is no approach, and the patient alone is shown.
    std::optional<std::size_t> selected() const { return selected_; }
    void select(std::size_t index);
    /// @throws InputError naming the existing approaches
    void select(std::string_view name);
    /// The state of the selected approach, or of the patient alone.
    const ApproachState& shown_state() const { return states_.at(shown_id()); }

    /// Adds an approach and selects it. @throws InputError as planner::add_approach() does; nothing changes then
    void add_approach(planner::Approach approach);
    /// Adds approaches in one step of the history; the selection stays. @throws as add_approach(); nothing changes then
    void add_approaches(std::vector<planner::Approach> approaches, std::string what);
    /// Puts a changed approach in the place of another and selects it.
    /// @param what the change in words, for "Undo"
    /// @throws InputError as planner::add_approach() does; nothing changes then
    void replace_approach(std::size_t index, planner::Approach approach, std::string what);
    /// Gives an approach another title. Its plan and pictures stay.
    /// @throws InputError as planner::set_title() does; nothing changes then
    void rename_approach(std::size_t index, const std::string& title);
    void remove_approach(std::size_t index);
    /// The edit that undo_edit() or redo_edit() would take back or make again, in words; nothing: there is none.
    std::optional<std::string> edit_to_undo() const;
    std::optional<std::string> edit_to_redo() const;
    void undo_edit();
    void redo_edit();

    ViewPreset view() const { return view_; }
    /// The view that is shown: without an approach, the patient from outside in place of the surgeon's eye.
    ViewPreset shown_view() const
    {
        if (view_ == ViewPreset::compare && !view_available(view_))
            return selected_ ? ViewPreset::surgeon : ViewPreset::overview;
        const bool of_approach = view_ == ViewPreset::surgeon || view_ == ViewPreset::incision;
        return of_approach && !selected_ ? ViewPreset::overview : view_;
    }
    void set_view(ViewPreset view)
    {
        if (view != view_)
            alone_.reset();
        view_ = view;
    }
    /// Whether the view can be shown: slices need a CT; the surgeon's eye and the incision's slices an approach; a
    /// comparison two planned approaches.
    bool view_available(ViewPreset view) const;

    /// The planned approaches, by index. Drafts are not among them: they are compared with nothing, and go into no
    /// file.
    std::vector<std::size_t> planned() const;
    /// Those of them that stand side by side; see planner::compared_approaches().
    std::vector<std::size_t> compared() const;
    /// Its place among all planned approaches, which gives its letter and colour wherever it is compared.
    /// @pre it is planned
    std::size_t place_of(std::size_t index) const;
    /// The names of the compared approaches when one comes or goes, with those that wait for a plan; nothing: there
    /// would be too few or too many.
    std::optional<std::vector<std::string>> compared_with(std::size_t index, bool is_compared) const;

    /// One picture of several that fills the view, by its place among them; nothing: all. Another view shows all again.
    void set_alone(std::optional<std::size_t> alone) { alone_ = alone; }
    std::optional<std::size_t> alone() const { return alone_; }

    /// Whether a planned approach is shown opened, or as before the cut.
    bool show_opened() const { return show_opened_; }
    void set_show_opened(bool opened) { show_opened_ = opened; }

    /// Numbers drawn as colours on opened fields; nothing: tissues in their colours. A field without these numbers is
    /// drawn in the colours of its tissues.
    void set_map(std::optional<FieldMapKind> map) { map_ = map; }
    std::optional<FieldMapKind> map() const { return map_; }
    /// Whether the shown approach has such numbers.
    bool map_available(FieldMapKind map) const;

    /// Whether request_plan() would do something: not where the approach waits, is being planned or is planned; but a
    /// plan takes the place of a draft.
    bool can_plan(std::size_t index, bool as_draft = false) const;
    /// Does nothing where can_plan() says no.
    void request_plan(std::size_t index, bool as_draft = false);
    /// What the team decided on this case.
    void set_decisions(planner::Decisions decisions) { decisions_ = std::move(decisions); }
    const planner::Decisions& decisions() const { return decisions_; }
    /// The approach that is chosen now, by its name in the case; empty: none.
    std::string chosen_approach() const
    {
        return decisions_.choices.empty() ? std::string() : decisions_.choices.back().approach;
    }

    /// Of the score in the comparison and in a search. @pre as planner::score_of()
    void set_weights(const planner::Weights& weights) { weights_ = weights; }
    const planner::Weights& weights() const { return weights_; }

    /// Withdraws all requests; the running plan stops at its next chance.
    void cancel();
    bool busy() const { return planning_.has_value(); }
    /// The approach that is being planned; nothing also when it was removed or changed meanwhile.
    std::optional<std::size_t> planning() const;
    /// Whether the running plan is no longer wanted.
    bool planning_unwanted() const;

    /// The approach to plan now, as ApproachState::as_draft says; nothing when a plan is running or nothing was
    /// requested.
    std::optional<std::size_t> begin_plan();
    /// The outcomes of begin_plan(). A result after cancel() is kept, because it is correct.
    void plan_done(FieldPictures field);
    void plan_cancelled();
    void plan_failed(Failure failure);

    /// The closed picture to make now: first that of the selected approach, then the others; that of the patient alone
    /// only where there is no approach.
    std::optional<ClosedWork> begin_closed();
    void closed_done(ClosedPictures pictures);
    void closed_failed(Failure failure);

    /// The approach whose plan of an earlier session to look for now: one that has its closed picture and no plan, the
    /// selected approach first.
    std::optional<std::size_t> begin_saved();
    /// @param field nothing: there is no saved plan
    void saved_done(std::optional<FieldPictures> field);

    /// For the slices of all approaches.
    void set_label_look(LabelLook look) { label_look_ = look; }
    LabelLook label_look() const { return label_look_; }

    /// For all pictures in space. Before the cut, what lies behind the wall is then drawn, too.
    void set_wall_look(WallLook look) { wall_look_ = look; }
    WallLook wall_look() const { return wall_look_; }
    /// Whether a wall that is seen through shows the planned cut; not while another incision is drawn.
    void set_cut_shown(bool shown) { cut_shown_ = shown; }
    /// Cuts the patient away up to the marked place; nothing: the patient is whole.
    void set_cut_side(std::optional<CutSide> side) { cut_side_ = side; }
    std::optional<CutSide> cut_side() const { return cut_side_; }
    /// Only the patient from outside is cut away: through an incision one looks at the whole wound.
    bool can_cut_away() const { return shown_view() == ViewPreset::overview || shown_view() == ViewPreset::slices; }
    /// The plane of the cut, with the CT on it where the patient is shown as in the CT; nothing: the patient is whole.
    std::optional<CutAway> cut_away() const;
    /// Whether organs are to be drawn that have not been given yet. True once only.
    bool take_anatomy_wish();
    void set_anatomy(std::vector<SurfaceItem> surfaces);
    /// What was picked in a picture, in words.
    std::string name_of(const Picked& picked) const;
    /// Whether what was picked lies where the CT shows it: not a moved wall, steel or a deflated lung.
    bool lies_as_in_ct(const Picked& picked) const;

    /// The slices show these labels, each in its own colour. Null: those that they were made with.
    void set_corrected_labels(std::shared_ptr<const mesh::LabelVolume> labels) { corrected_ = std::move(labels); }

    /// @param index of kGreyWindows, for the slices of all approaches
    void set_grey_window(std::size_t index);
    std::size_t grey_window() const { return grey_window_; }
    /// Where the slices of the selected approach, or of the patient alone, meet; nothing: there are none yet.
    std::optional<Vec3> slice_place() const;
    /// Where the slices meet; without slices, the place that was marked last, or the middle of the patient.
    Vec3 marked_place() const;
    /// Moves the slices that are shown, and the mark in space.
    void set_slice_point(const Vec3& point);

    ShownSource shown_source() const;
    /// Adds a place to the measurement that was begun, or begins another: after a distance comes an angle, then a new
    /// measurement. @returns the measurement so far, in words
    std::string measure(const Vec3& place);
    /// Adds a corner to the area that is measured, or begins one.
    std::string measure_area(const Vec3& corner);
    /// Ends the last measurement: what is measured next is another one. Places that give no number go.
    void end_measurement();
    void forget_measurements() { measurements_.clear(); }
    /// Takes the last place back. @return false when there is none
    bool unmeasure();
    bool has_measurements() const { return !measurements_.empty(); }

    /// The scenes to draw now; empty while the first picture is being made. Slices give four scenes: the three planes
    /// and the overview.
    std::vector<Scene> shown_scenes() const;
    /// Puts the selected approach's name into the title of a picture that was made before the approach was renamed.
    void put_present_name(Scene& scene) const;

private:
    std::vector<Scene> unmeasured_scenes() const;
    /// A scene in space with the look of the wall, the cut and the mark.
    Scene looked_into(Scene scene) const;
    /// A slice as grey window and look of labels want it.
    void dress(SliceItem& slice) const;
    bool opened_shown() const { return shown_source().opened; }
    /// A scene of a field in the colours of the map, where one is chosen.
    Scene mapped(const FieldPictures& field, const Scene& scene) const;
    std::vector<Scene> compared_scenes() const;
    static constexpr std::size_t kPatientAlone = 0; ///< id

    /// The list of approaches at one time.
    struct Edition {
        std::vector<planner::Approach> approaches;
        std::vector<std::size_t> ids;
        std::optional<std::size_t> selected;
        std::string what; ///< the edit between this edition and the next, in words
    };
    std::size_t shown_id() const { return selected_ ? ids_.at(*selected_) : kPatientAlone; }
    ApproachState& state_of(std::size_t index) { return states_.at(ids_.at(index)); }
    std::size_t new_id();
    Edition edition(std::string what) const;
    void begin_edit(std::string what);
    void take(std::vector<Edition>& from, std::vector<Edition>& to);
    /// Withdraws the requests for approaches that are no longer in the list.
    void withdraw_absent();

    planner::Case case_;
    std::vector<std::size_t> ids_; ///< one per approach
    std::map<std::size_t, ApproachState> states_; ///< by id; also of approaches that undo and redo bring back
    std::vector<Edition> undo_, redo_;
    std::optional<std::size_t> selected_;
    ViewPreset view_ = ViewPreset::surgeon;
    bool show_opened_ = true;
    std::size_t grey_window_ = 0;
    std::optional<FieldMapKind> map_;
    std::shared_ptr<const mesh::LabelVolume> corrected_;
    LabelLook label_look_ = LabelLook::filled;
    WallLook wall_look_ = WallLook::solid;
    bool cut_shown_ = true;
    std::optional<CutSide> cut_side_;
    std::shared_ptr<const std::vector<SurfaceItem>> anatomy_; ///< null: not given yet
    bool anatomy_wished_ = false;
    planner::Decisions decisions_;
    planner::Weights weights_ = planner::default_weights();
    std::optional<std::size_t> alone_;
    std::vector<Measurement> measurements_;
    bool measurement_ended_ = false; ///< the last measurement takes no more places
    std::deque<std::size_t> waiting_; ///< ids
    std::optional<std::size_t> planning_, making_closed_, reading_saved_; ///< ids
};

/// The camera of the surgeon: along the blade direction at the middle of the incision.
/// @param up up vector of the picture, unless parallel to the line of sight
Camera surgeon_camera(const planner::Approach& approach, const Vec3& up);

} // namespace retractor::ui
