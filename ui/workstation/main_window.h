#pragma once
// The main window: approaches on the left, the picture in the middle, the numbers on the right. Worker threads read
// cases, draw the closed patient and plan. The window starts the work and shows the results.

#include "mesh/base/serial_executor.h"
#include "ui/workstation/cutting/knife_tool.h"
#include "ui/workstation/planning/planning_backend.h"
#include "ui/workstation/planning/session_model.h"

#include <QMainWindow>
#include <QTimer>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

class QAction;
class QActionGroup;
class QLabel;
class QMenu;
class QProgressBar;
class QPushButton;
class QTabWidget;

namespace retractor::planner {
struct Palpable;
}

namespace retractor::ui {

class ApproachList;
class MetricsPanel;
class PictureView;

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

    /// @throws InputError naming the existing approaches
    void select(const std::string& approach);
    void set_view(ViewPreset view);
    void plan_selected();
    void plan_all();
    /// Takes back an open stroke, or else stops planning.
    void cancel();
    /// Changes the mode of the knife. The first use starts the session of the selected approach.
    void set_knife(KnifeMode mode);

    /// Makes a label of the open case palpable in the background, then calls on_palpable. @pre a case is open
    void palpate(const std::string& structure);
    /// Called with the scene that palpate() made and with its notes.
    std::function<void(planner::Palpable)> on_palpable;

    /// Called when an opened file is a palpation scene instead of a case.
    std::function<void(const std::filesystem::path&)> on_palpation_scene;

    /// Writes the picture in the middle as PNG. @throws IoError
    void save_picture(const std::filesystem::path& path);
    /// Writes the whole window as PNG. @throws IoError
    void save_screenshot(const std::filesystem::path& path);

    /// Whether nothing is being read, drawn, planned or cut.
    bool idle() const;
    /// Null before a case is open.
    const SessionModel* model() const { return model_.get(); }
    PictureView& view() { return *view_; }
    ApproachList& approach_list() { return *list_; }
    KnifeTool& knife() { return *knife_; }
    KnifePanel& knife_panel() { return *knife_panel_; }
    /// The error in the status line; empty: none.
    std::string error_line() const { return error_; }
    std::string message_line() const; ///< text of the status line, error or not

protected:
    /// Asks before a plan that is being calculated is lost.
    void closeEvent(QCloseEvent* event) override;

private:
    void make_actions();
    void make_panes();
    void make_status_line();
    void make_knife();
    void make_knife_actions(QMenu& menu, QToolBar& bar);

    void ask_for_case();
    void ask_for_picture_file();
    void ask_for_structure();
    void ask_for_export_file();
    void show_about();

    void hand_out_work();
    void make_closed(std::size_t index);
    void make_plan(std::size_t index);
    /// Runs `deliver` in the window's thread.
    void post_back(std::function<void()> deliver);
    /// Runs `deliver` in the window's thread, unless another case was opened meanwhile.
    void post_back(int generation, std::function<void()> deliver);

    void show_all(); ///< list, numbers, actions, picture
    void show_picture(); ///< keeps a picture that is still valid, with its camera
    void move_slices(const Vec3& point);
    void set_grey_window(std::size_t index);
    bool slices_shown() const;
    void show_slices();
    void show_knife(); ///< starts the session of the selected approach while the knife's tab is open
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
    int reading_ = 0; ///< number of cases that are being read
    int closed_running_ = 0, plans_running_ = 0;
    std::string error_;
    ShownSource shown_; ///< source of the shown picture

    ApproachList* list_ = nullptr;
    PictureView* view_ = nullptr;
    MetricsPanel* panel_ = nullptr;
    KnifePanel* knife_panel_ = nullptr;
    QTabWidget* tabs_ = nullptr;
    QAction *knife_action_ = nullptr, *line_action_ = nullptr, *hook_action_ = nullptr, *take_out_action_ = nullptr,
            *undo_ = nullptr, *redo_ = nullptr;
    QActionGroup* grey_windows_ = nullptr;
    QAction *surgeon_ = nullptr, *overview_ = nullptr, *slices_ = nullptr;
    QAction *opened_ = nullptr, *plan_ = nullptr, *plan_all_ = nullptr, *cancel_ = nullptr, *save_ = nullptr,
            *palpate_ = nullptr;
    QLabel* message_ = nullptr;
    QProgressBar* progress_ = nullptr;
    QPushButton* cancel_button_ = nullptr;
    QTimer progress_timer_;

    // Last members: they must end before the data that their tasks use.
    SerialExecutor reading_executor_;
    SerialExecutor closed_executor_;
    SerialExecutor planning_executor_;
    std::unique_ptr<KnifeTool> knife_;
};

} // namespace retractor::ui
