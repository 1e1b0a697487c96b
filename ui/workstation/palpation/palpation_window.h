#pragma once
// The window for palpation: the tissue in the middle, pressure and force over time below, numbers and settings on the
// right. Other threads follow the tissue and run the servo. The window draws the newest frame.

#include "planner/session/palpation_worker.h"
#include "ui/workstation/palpation/palpation_panel.h"
#include "ui/workstation/palpation/palpation_picture.h"
#include "ui/workstation/palpation/shown_wound.h"
#include "ui/workstation/palpation/strip_chart.h"
#include "ui/workstation/palpation/touch_tool.h"

#include <QMainWindow>
#include <QTimer>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

class QLabel;

namespace retractor::ui {

class PalpationWindow : public QMainWindow {
public:
    explicit PalpationWindow(planner::PalpationBackend backend, QWidget* parent = nullptr);
    /// Lets go of the devices and ends the palpation.
    ~PalpationWindow() override;

    /// Replaces the palpated tissue. @param notes notes about the scene, shown beside the notes about its tissue
    void open(
        datasets::PalpationScene scene, const planner::PalpationSetup& setup = {}, std::vector<std::string> notes = {});
    /// Replaces the palpated tissue by one that is touched through the wound round it.
    void open_through(ShownWound wound, const planner::PalpationSetup& setup = {});
    /// Opens a scene. When the file has an error, the window shows the error and the present palpation goes on.
    void open_file(const std::filesystem::path& path);

    /// Replaces the built-in hands on the fingertips.
    void show_hands(const ShownHands& hands);

    void take_finger(std::size_t finger);
    void lift_all();
    /// Moves the middle of the template.
    void place_template(const Vec3& centre);
    void apply_template();
    void start_recording();
    void stop_recording(const std::filesystem::path& path);

    /// Writes the whole window as PNG. @throws IoError
    void save_screenshot(const std::filesystem::path& path);

    /// Whether the tissue is ready and every request is done.
    bool idle() const;
    PictureView& view() { return *view_; }
    PalpationPanel& panel() { return *panel_; }
    StripChart& chart() { return *chart_; }
    TouchTool& tool() { return *tool_; }
    /// The newest snapshot.
    const planner::PalpationSnapshot& snapshot() const { return *snapshot_; }
    /// The newest drawn frame. @pre snapshot().phase is ready
    const planner::PalpationFrame& frame() const { return *frame_; }
    /// What the finger reaches through a wound, and what stops it; empty: nothing is round the tissue.
    QString reach_text() const;
    /// The error in the status line; empty: none.
    std::string error_line() const { return error_; }

private:
    void make_panes();
    void make_actions();
    void make_tool();
    void make_panel_calls();
    void poll();
    void take_snapshot();
    void take_tool();
    void draw();
    void begin(const planner::PalpationSetup& setup);
    void show_scene();
    void show_reach();
    /// What is put through the wound; null: nothing is round the tissue.
    const haptics::FingerAccess* access_in_hand() const;
    PalpationViewOptions view_options() const;
    void ask_for_scene();
    void ask_for_hand();
    void record_or_stop();
    void ask_for_place();
    void say(const std::string& text, bool refused);

    planner::PalpationBackend backend_;
    datasets::PalpationScene scene_;
    std::vector<std::string> scene_notes_;
    std::unique_ptr<planner::PalpationWorker> worker_; ///< null when no scene is open
    std::shared_ptr<const planner::PalpationSnapshot> snapshot_ = std::make_shared<const planner::PalpationSnapshot>();
    const planner::PalpationFrame* frame_ = nullptr; ///< the newest frame of the worker
    std::unique_ptr<PalpationPicture> picture_;
    std::optional<ShownHands> hands_; ///< hands read from a file
    std::optional<ShownWound> wound_; ///< without its tissue, which is scene_; nothing: nothing is round the tissue
    QString reach_said_; ///< by show_reach(), the last time
    std::shared_ptr<const TriMesh> surface_;
    std::size_t answers_ = 0;
    std::optional<haptics::ElasticTemplate> mark_;
    std::array<bool, planner::kMostFingers> grips_ {};
    std::string error_;

    PictureView* view_ = nullptr;
    StripChart* chart_ = nullptr;
    PalpationPanel* panel_ = nullptr;
    QLabel *hint_ = nullptr, *reach_ = nullptr, *message_ = nullptr;
    std::unique_ptr<TouchTool> tool_;
    QTimer poll_timer_;
};

} // namespace retractor::ui
