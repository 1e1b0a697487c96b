#pragma once
// The main window. Before a case is open: the start page. Then approaches on the left, the picture in the middle, the
// numbers on the right. Worker threads read and write cases, draw the closed patient and plan. The window starts the
// work and shows the results.

#include "mesh/base/serial_executor.h"
#include "planner/decision/presentation.h"
#include "ui/workstation/cutting/knife_tool.h"
#include "ui/workstation/help/session_log.h"
#include "ui/workstation/planning/approach_editor.h"
#include "ui/workstation/planning/planning_backend.h"
#include "ui/workstation/planning/session_model.h"

#include <QMainWindow>
#include <QPointer>
#include <QTimer>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

class QAction;
class QActionGroup;
class QDialog;
class QGridLayout;
class QLabel;
class QMenu;
class QProgressBar;
class QPushButton;
class QStackedWidget;
class QTabWidget;
class QToolBar;

namespace retractor::planner {
struct Palpable;
}

namespace retractor::ui {

class ApproachList;
class Banner;
class CaseLock;
class StepBar;
class LabelEditor;
class LabelPanel;
class MetricsPanel;
class NotesWindow;
class PictureView;
class SearchDialog;
class StartPage;

class MainWindow : public QMainWindow {
public:
    using BackendFactory = std::function<PlanningBackend(const planner::Case&)>;

    explicit MainWindow(BackendFactory factory, QWidget* parent = nullptr);
    /// Cancels planning and waits for its end.
    ~MainWindow() override;

    /// Shows a case that is in memory.
    void open(planner::Case planned_case);
    /// Reads a case in the background. When reading fails, the shown case stays.
    void open_file(const std::filesystem::path& path);
    /// Shows the start page again. Plans of the case are lost, its approaches are in its file.
    void close_case();
    /// Asks how to import a study. @param study looked through at once; empty: the user names it
    void import_study(const std::filesystem::path& study = {});
    /// Writes a demo patient into a new folder, in the background, and opens it.
    void open_demo_patient(const std::filesystem::path& folder);
    /// From now on opened cases are listed on the start page, with their pictures.
    void remember_cases();

    /// @throws InputError naming the existing approaches
    void select(const std::string& approach);
    void set_view(ViewPreset view);
    /// How the body's wall is drawn in space. @pre a case is open
    void set_wall_look(WallLook look);
    /// Shows planned approaches opened, or as before the cut. @pre a case is open
    void set_opened(bool opened);
    /// @param as_draft quickly, see PlanningBackend::draft
    void plan_selected(bool as_draft = false);
    void plan_all();
    /// Takes back an open stroke, or else stops planning.
    void cancel();
    /// Changes the mode of the knife. The first use starts the session of the selected approach.
    void set_knife(KnifeMode mode);

    /// Makes a label of the open case palpable in the background, then calls on_palpable. @pre a case is open
    void palpate(const std::string& structure);
    /// Makes the target of the selected, planned approach palpable through its opened wound, in the background, then
    /// calls on_palpable_wound. @pre a case is open
    void palpate_through_wound();
    std::function<void(ShownWound)> on_palpable_wound;
    /// Called with the scene that palpate() or the start page made, and with its notes.
    std::function<void(planner::Palpable)> on_palpable;

    /// Called when an opened file is a palpation scene instead of a case.
    std::function<void(const std::filesystem::path&)> on_palpation_scene;

    /// Writes the picture in the middle as PNG. @throws IoError
    void save_picture(const std::filesystem::path& path);
    /// Writes the whole window as PNG. @throws IoError
    void save_screenshot(const std::filesystem::path& path);

    /// Writes a movie of the case and its plans, in the background.
    /// @param with_pictures also every frame, into a folder beside the file
    void save_movie(const std::filesystem::path& file, bool with_pictures = false);
    /// Writes the report page of the case and its plans, in the background.
    void save_report(const std::filesystem::path& file);

    /// Begins or ends the conference: full screen, large type, the plans step by step.
    void set_conference(bool on);
    bool in_conference() const { return !steps_.empty(); }
    StepBar& conference_bar() { return *conference_bar_; }
    StepBar& tour_bar() { return *tour_bar_; }
    NotesWindow& notes() { return *notes_; }
    /// Shows what the answers of several case files come to.
    void summarize_answers(const std::vector<std::filesystem::path>& case_files);

    /// The log to be attached to a report of a fault.
    std::string log_text();

    /// Whether nothing is being read, drawn, planned or cut.
    bool idle() const;
    /// Null before a case is open.
    const SessionModel* model() const { return model_.get(); }
    PictureView& view() { return *view_; }
    ApproachList& approach_list() { return *list_; }
    KnifeTool& knife() { return *knife_; }
    KnifePanel& knife_panel() { return *knife_panel_; }
    ApproachEditor& editor() { return *editor_; }
    LabelEditor& label_editor() { return *labels_; }
    LabelPanel& label_panel() { return *label_panel_; }
    /// The open dialog that searches for an incision; null: there is none.
    SearchDialog* search_dialog() const;
    StartPage& start_page() { return *start_page_; }
    bool start_page_shown() const;
    /// Whether another window changes the case, so that this one only looks at it.
    bool only_looks() const;
    /// Why the case is not saved, as the banner says it; empty: it is.
    std::string not_saved() const { return not_saved_; }
    /// The error in the status line; empty: none.
    std::string error_line() const { return error_; }
    std::string message_line() const; ///< text of the status line, error or not

protected:
    /// Asks before a plan that is being calculated is lost.
    void closeEvent(QCloseEvent* event) override;
    void dragEnterEvent(QDragEnterEvent* event) override;
    void dropEvent(QDropEvent* event) override;

private:
    // main_actions.cpp
    QAction* add_action(
        QMenu& menu, const QString& text, const QKeySequence& key, const QString& tip, std::function<void()> run);
    void make_actions();
    void make_language_actions(QMenu& menu);
    void make_file_actions(QMenu& menu);
    void make_view_actions(QMenu& menu);
    void make_approach_actions(QMenu& menu);
    void make_knife_actions(QMenu& menu);
    void make_tool_bar();

    void make_panes();
    QWidget* make_approach_pane();
    void make_start_page();
    void make_status_line();
    void make_knife();
    void make_editor();
    void make_labels();

    // main_tour.cpp
    void make_tour();
    /// Shows what the window can do with the open case; without a case, with a new demo patient.
    void begin_tour();
    void go_to_tour_step(std::size_t step);
    void end_tour();
    bool in_tour() const { return tour_step_.has_value(); }

    // main_conference.cpp
    void make_conference();
    /// The steps of the case as it is now.
    std::vector<planner::PresentationStep> steps_now() const;
    void go_to_step(std::size_t step);
    void step_by(int steps);
    /// From where the present step looks, where it has a place of its own and its picture is shown.
    void show_camera_of_step();
    void keep_view();
    void forget_view();
    /// More steps where pictures or plans have come meanwhile; the present step stays.
    void renew_steps();
    void show_frame(bool shown); ///< menus, tool bar, panes and status line

    void search_incisions();
    void change_weights();
    void close_case_dialogs(); ///< the search and the weights belong to a case
    void choose_approach();
    void ask_questions();
    void ask_for_answered_cases();
    void show_notes(bool shown);
    void show_step_in_notes();
    /// Reads the decisions again, changes them and writes them, in the background.
    /// @param message afterwards; null: the means of the answers; empty: none
    void change_decisions(std::function<void(planner::Decisions&)> change, const QString& message);
    void read_decisions();
    void compare(std::size_t id, bool is_compared);
    void enlarge(std::size_t scene);
    void set_label_look(LabelLook look);
    // main_look.cpp
    void make_look_actions(QMenu& menu);
    void next_wall_look();
    void set_cut_side(std::optional<CutSide> side);
    void next_cut_side();
    void make_anatomy();
    /// Looks through an endoscope into the opened wound, or turns the one that is there. @param optics_deg 0 or 30
    void look_through_endoscope(double optics_deg);
    void show_space_again(); ///< pictures in space anew, each from where it is seen now
    void show_place(); ///< the marked place has moved
    void step_cut(double notches);
    void name_place(std::size_t scene, const planner::Ray& ray);

    void set_map(std::optional<FieldMapKind> map);
    std::optional<FieldMapKind> map_of_step(const planner::PresentationStep& step) const;
    WallLook wall_of_step(const planner::PresentationStep& step) const;
    void show_wall_as(WallLook look);
    void select_compared(std::size_t place);
    void open_manual();
    bool labels_tab_open() const;
    /// Gives the mouse to the brush on the slices.
    void correct_labels();
    /// Writes corrected labels and the case, and opens the case anew: its pictures and plans are others.
    /// @param over_others also where another program has changed the file meanwhile
    void save_labels(const planner::Case& corrected, const std::shared_ptr<const mesh::LabelVolume>& labels,
        bool over_others = false);
    void put_labels_into_changed_case(const std::shared_ptr<const mesh::LabelVolume>& labels);
    void show_corrected_labels();
    void say_labels_not_saved();
    void draw_incision();
    void move_incision();
    void undo();
    void redo();
    /// Writes the case. @param over_others also where another program has changed the file meanwhile
    void save_case(bool over_others = false);
    void lock_case();
    void show_not_saved(const std::string& reason, bool changed_by_others);
    /// Asks before a plan that is being calculated, or approaches that could not be saved, are lost.
    /// @return whether to go on
    bool may_leave_case(const QString& question);
    bool may_lose(const QString& question, const QString& what, const QString& go_on);
    void cancel_planning();
    void cancel_palpation(); ///< that is being prepared
    void cancel_work(); ///< planning, or else the preparation of a palpation and what is being saved
    void open_as_read(planner::Case planned_case, std::optional<std::filesystem::file_time_type> read_at);
    void run_start_work(const QString& what, std::function<std::function<void()>(const Job&)> task);
    void prepare_palpation(const QString& message, std::function<std::function<void()>(const Job&)> task);
    void open_trainer();

    void ask_for_case();
    void ask_for_structure();

    // main_exports.cpp
    void run_export(const QString& file, std::function<bool(const Job&)> write);
    PlanningBackend::Shown shown_plans() const;
    void ask_for_picture_file();
    void ask_for_movie_file();
    void ask_for_report_file();
    void ask_for_export_file();
    void ask_for_log_file();
    void show_about();

    void hand_out_work();
    void make_closed(const ClosedWork& work);
    void read_saved_plan(std::size_t index);
    void make_plan(std::size_t index);
    /// Runs `deliver` in the window's thread.
    void post_back(std::function<void()> deliver);
    /// Runs `deliver` in the window's thread, unless another case was opened meanwhile.
    void post_back(int generation, std::function<void()> deliver);

    void show_all(); ///< list, numbers, actions, picture
    void show_linked();
    void reset_view();
    void show_picture(); ///< keeps a picture that is still valid, with its camera
    void move_slices(const Vec3& point);
    /// @param area clicks are the corners of an area
    void set_measuring(bool on, bool area = false);
    /// Ends what is drawn or measured, with Enter.
    void finish();
    void measure_at(const QPointF& at);
    void forget_measurements();
    void show_measurements();
    void show_again(const std::function<bool(const Scene&)>& which);
    void set_grey_window(std::size_t index);
    bool slices_shown() const;
    void show_slices();
    /// The end of the blade on the slice across the incision, and its drag.
    std::optional<SliceHandle> blade_handle() const;
    void drag_blade(const Vec3& place, bool last);
    void show_actions();
    void show_undo();
    void show_start_page();
    void show_knife();
    void show_cuts_not_saved(); ///< starts the session of the selected approach while the knife's tab is open
    bool knife_tab_open() const;
    Scene knife_scene(const Scene& surroundings, const ShownSource& source) const;
    void show_progress();
    void show_error(const Failure& failure);
    void reading_failed(const Failure& failure);
    void show_message(const QString& text);
    void clear_error();

    BackendFactory factory_;
    std::unique_ptr<SessionModel> model_;
    PlanningBackend backend_;
    int generation_ = 0; ///< number of the case; results for an older case are dropped
    int reading_ = 0; ///< number of cases that are being read, and of palpations that are being prepared
    int palpations_prepared_ = 0;
    int saving_ = 0; ///< number of cases that are being written
    int deciding_ = 0; ///< of them, number of changes to the decisions
    std::string not_saved_;
    bool remembers_ = false; ///< opened cases are listed on the start page
    std::filesystem::path pictured_; ///< the case file whose picture was kept last
    QString start_work_; ///< what the start page waits for, in words
    int closed_running_ = 0, plans_running_ = 0, exports_running_ = 0;
    std::string error_;
    ShownSource shown_; ///< source of the shown picture

    QStackedWidget* pages_ = nullptr;
    StartPage* start_page_ = nullptr;
    Banner* not_saved_banner_ = nullptr;
    Banner* cuts_banner_ = nullptr; ///< while cuts by hand cannot be saved
    Banner* looking_banner_ = nullptr; ///< while another window changes the case
    std::unique_ptr<CaseLock> lock_; ///< of the open case; null: it has no file
    bool changed_by_others_ = false; ///< the case is not saved, because another program has changed it
    ApproachList* list_ = nullptr;
    QGridLayout* approach_buttons_ = nullptr;
    PictureView* view_ = nullptr;
    MetricsPanel* panel_ = nullptr;
    KnifePanel* knife_panel_ = nullptr;
    LabelPanel* label_panel_ = nullptr;
    QWidget* approach_pane_ = nullptr;
    QToolBar* tool_bar_ = nullptr;
    std::optional<FieldMapKind> map_before_conference_ {}; ///< shown again behind the conference
    WallLook wall_before_conference_ = WallLook::solid; ///< as map_before_conference_
    ViewPreset view_before_conference_ = ViewPreset::surgeon; ///< the same
    bool opened_before_conference_ = true; ///< the same
    StepBar* conference_bar_ = nullptr;
    std::vector<planner::PresentationStep> steps_; ///< of the conference; empty: there is none
    std::size_t step_ = 0;
    StepBar* tour_bar_ = nullptr;
    NotesWindow* notes_ = nullptr; ///< the presenter's
    std::optional<std::size_t> tour_step_; ///< nothing: there is no tour
    std::filesystem::path tour_case_; ///< the tour begins when this case is opened; empty: none
    double optics_deg_ = -1.0, optics_turned_deg_ = 0.0; ///< of the endoscope that is looked through; -1: none
    std::string decided_by_; ///< who decided or answered last, as the next proposal
    bool was_maximized_ = false; ///< before the conference
    SessionLog log_;
    QTabWidget* tabs_ = nullptr;
    QAction *knife_action_ = nullptr, *line_action_ = nullptr, *hook_action_ = nullptr, *take_out_action_ = nullptr,
            *undo_ = nullptr, *redo_ = nullptr;
    QAction *new_approach_ = nullptr, *draw_ = nullptr, *move_ = nullptr, *finish_ = nullptr, *change_ = nullptr,
            *site_ = nullptr, *duplicate_ = nullptr, *neighbours_ = nullptr, *remove_ = nullptr, *choose_ = nullptr,
            *questions_ = nullptr, *close_case_ = nullptr, *search_ = nullptr, *weights_ = nullptr,
            *notes_action_ = nullptr;
    QActionGroup* grey_windows_ = nullptr;
    QAction *surgeon_ = nullptr, *overview_ = nullptr, *slices_ = nullptr, *incision_ = nullptr, *compare_ = nullptr,
            *measure_ = nullptr, *measure_area_ = nullptr, *forget_measurements_ = nullptr, *large_ = nullptr,
            *straight_optics_ = nullptr, *oblique_optics_ = nullptr, *correct_ = nullptr, *confer_ = nullptr,
            *linked_ = nullptr, *reset_view_ = nullptr;
    QActionGroup *label_looks_ = nullptr, *presenter_keys_ = nullptr, *maps_ = nullptr, *wall_looks_ = nullptr,
                 *cut_sides_ = nullptr;
    QAction *opened_ = nullptr, *plan_ = nullptr, *plan_all_ = nullptr, *draft_ = nullptr, *cancel_ = nullptr,
            *save_ = nullptr, *palpate_ = nullptr, *palpate_through_ = nullptr, *movie_ = nullptr, *report_ = nullptr,
            *keep_view_ = nullptr, *forget_view_ = nullptr;
    QLabel* message_ = nullptr;
    QProgressBar* progress_ = nullptr;
    QPushButton* cancel_button_ = nullptr;
    QTimer progress_timer_;
    QTimer mark_timer_; ///< until a moved mark is drawn
    QPointer<QDialog> search_dialog_, weights_dialog_; ///< a SearchDialog, and a WeightsDialog
    std::unique_ptr<ApproachEditor> editor_;
    std::unique_ptr<PictureTool> measure_tool_;
    bool measuring_ = false, measuring_area_ = false; ///< the mouse measures

    /// Of the case file as it was read or written last; used by the saving executor's thread.
    std::optional<std::filesystem::file_time_type> case_time_;

    // Last members: they must end before the data that their tasks use.
    SerialExecutor reading_executor_;
    SerialExecutor saving_executor_ { { .when_destroyed = WaitingTasks::run } }; ///< what was edited is written
    SerialExecutor closed_executor_;
    SerialExecutor planning_executor_;
    SerialExecutor export_executor_;
    std::unique_ptr<KnifeTool> knife_;
    std::unique_ptr<LabelEditor> labels_;
};

} // namespace retractor::ui
