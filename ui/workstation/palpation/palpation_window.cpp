#include "ui/workstation/palpation/palpation_window.h"

#include "datasets/phantoms/palpation_scene_file.h"
#include "haptics/hand/hand_file.h"
#include "mesh/base/text_format.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/language/stage_words.h"
#include "ui/workstation/planning/session_model.h"
#include "ui/workstation/view/png_file.h"
#include "ui/workstation/view/theme.h"

#include <QApplication>
#include <QCheckBox>
#include <QDoubleSpinBox>
#include <QFileDialog>
#include <QLabel>
#include <QMenuBar>
#include <QScrollArea>
#include <QShortcut>
#include <QSplitter>
#include <QStatusBar>
#include <QVBoxLayout>

#include <algorithm>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr int kPollMs = 30; ///< without a graphics card a picture takes a large part of this time
    constexpr double kPressShare = 0.375; ///< initial depth of a press, as a share of the fingertip's radius
    constexpr std::size_t kWoundTriangles = 4 * PictureView::kCoarseTriangles;
    constexpr const char* kHint
        = "Left button: press the fingertip in   \u00b7   drag: slide along   \u00b7   wheel while pressing: press "
          "deeper or less   \u00b7   keys 1, 2, \u2026: select another finger, this finger stays   \u00b7   Esc: lift "
          "all   \u00b7   right button: turn the camera";

} // namespace

PalpationWindow::PalpationWindow(planner::PalpationBackend backend, QWidget* parent)
    : QMainWindow(parent)
    , backend_(std::move(backend))
{
    setWindowTitle("Retractor - palpation");
    resize(1280, 860);
    make_panes();
    make_tool();
    make_panel_calls();
    make_actions();
    poll_timer_.setInterval(kPollMs);
    connect(&poll_timer_, &QTimer::timeout, this, [this] { poll(); });
    view_->show_note("Open a palpation scene to begin: File, Open scene");
    translate_texts(*this);
}

PalpationWindow::~PalpationWindow()
{
    poll_timer_.stop();
    tool_.reset();
    view_->set_live(nullptr);
}

void PalpationWindow::make_panes()
{
    view_ = new PictureView;
    chart_ = new StripChart;
    panel_ = new PalpationPanel(backend_.models);
    hint_ = new QLabel(kHint);
    hint_->setAlignment(Qt::AlignCenter);
    hint_->setStyleSheet("background: #262b30; color: #c8d0d6; padding: 5px;");
    hint_->setWordWrap(true);
    auto* left = new QWidget;
    auto* column = new QVBoxLayout(left);
    column->setContentsMargins(0, 0, 0, 0);
    column->setSpacing(0);
    auto* middle = new QSplitter(Qt::Vertical);
    auto* picture = new QWidget;
    auto* picture_column = new QVBoxLayout(picture);
    picture_column->setContentsMargins(0, 0, 0, 0);
    picture_column->setSpacing(0);
    picture_column->addWidget(view_, 1);
    reach_ = new QLabel;
    reach_->setAlignment(Qt::AlignCenter);
    reach_->setStyleSheet("background: #1c2733; color: #f0f4f7; padding: 6px; font-weight: bold;");
    reach_->setWordWrap(true);
    reach_->hide();
    picture_column->addWidget(reach_);
    picture_column->addWidget(hint_);
    middle->addWidget(picture);
    middle->addWidget(chart_);
    middle->setSizes({ 560, 250 });
    middle->setStretchFactor(0, 1);
    middle->setStretchFactor(1, 0);
    column->addWidget(middle);
    auto* scroll = new QScrollArea;
    scroll->setWidget(panel_);
    scroll->setWidgetResizable(true);
    scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    auto* panes = new QSplitter;
    panes->addWidget(left);
    panes->addWidget(scroll);
    panes->setHandleWidth(2);
    panes->setChildrenCollapsible(false);
    panes->setSizes({ 930, 350 });
    panes->setStretchFactor(0, 1);
    panes->setStretchFactor(1, 0);
    setCentralWidget(panes);
    message_ = add_message(*statusBar());
    add_notice(*statusBar());
}

void PalpationWindow::make_tool()
{
    tool_ = std::make_unique<TouchTool>(*view_);
    tool_->on_change = [this] {
        panel_->show_depth(tool_->depth());
        const bool gripped = grips_[tool_->finger()];
        if (panel_->grip_box().isChecked() != gripped) {
            const QSignalBlocker quiet(panel_->grip_box());
            panel_->grip_box().setChecked(gripped);
        }
    };
    tool_->on_refused = [this](const std::string& text) { say(text, true); };
}

void PalpationWindow::make_panel_calls()
{
    const auto with_worker = [this](auto order) {
        return [this, order](auto... values) {
            if (worker_ != nullptr)
                order(values...);
        };
    };
    panel_->on_setup = with_worker([this] {
        planner::PalpationSetup setup = panel_->setup();
        if (view_->is_drawn()) {
            const Camera camera = view_->camera();
            const Vec3 out = (camera.eye - camera.aim).normalized(), right = camera.up.cross(out).normalized();
            setup.towards_viewer.col(0) = right;
            setup.towards_viewer.col(1) = out.cross(right);
            setup.towards_viewer.col(2) = out;
        }
        if (setup.model != snapshot_->setup.model) {
            lift_all();
            view_->show_note("Preparing the tissue again …");
        }
        worker_->run(planner::palpation::ChangeSetup { setup });
    });
    panel_->on_command = with_worker([this](const planner::palpation::Command& command) { worker_->run(command); });
    panel_->on_reset = with_worker([this] {
        lift_all();
        mark_.reset();
        panel_->set_edit_place(false);
        view_->show_note("Preparing the tissue again …");
        worker_->run(planner::palpation::Reset {});
        worker_->run(planner::palpation::Rearm {});
    });
    panel_->on_grip = with_worker([this](bool held) {
        grips_[tool_->finger()] = held;
        worker_->run(planner::palpation::Grip { tool_->finger(), held });
    });
    panel_->on_depth = [this](double mm) { tool_->set_depth(mm); };
    panel_->on_lift = [this] { lift_all(); };
    panel_->on_view = with_worker([this] { draw(); });
    panel_->on_place = [this] { ask_for_place(); };
    panel_->on_apply = [this] { apply_template(); };
    panel_->on_template = [this] {
        if (mark_)
            place_template(mark_->centre);
    };
    panel_->on_record = [this] { record_or_stop(); };
}

void PalpationWindow::make_actions()
{
    QMenu* file = menuBar()->addMenu("&File");
    QMenu* fingers = menuBar()->addMenu("F&ingers");
    QMenu* show = menuBar()->addMenu("&Show");
    const auto add = [this](QMenu* menu, const QString& text, const QKeySequence& key, auto run) {
        QAction* action = menu->addAction(text);
        action->setShortcut(key);
        connect(action, &QAction::triggered, this, run);
    };
    add(file, "Open scene…", QKeySequence::Open, [this] { ask_for_scene(); });
    add(file, "Record or stop", Qt::Key_R, [this] { record_or_stop(); });
    file->addSeparator();
    add(file, "Close", QKeySequence("Ctrl+W"), [this] { close(); });
    add(file, "Quit", QKeySequence::Quit, [this] { QApplication::closeAllWindows(); });
    for (std::size_t f = 0; f < planner::kMostFingers; ++f)
        add(fingers, QString("Select finger %1").arg(f + 1), QKeySequence(Qt::Key_1 + static_cast<int>(f)),
            [this, f] { take_finger(f); });
    add(fingers, "Grip", Qt::Key_G, [this] { panel_->grip_box().click(); });
    add(fingers, "Lift all", Qt::Key_Escape, [this] { lift_all(); });
    add(show, "Hand from a file…", {}, [this] { ask_for_hand(); });
    add(show, "Hand", Qt::Key_H, [this] { panel_->hands_box().click(); });
    add(show, "Spheres inside", Qt::Key_S, [this] { panel_->spheres_box().click(); });
    add(show, "Place the template", Qt::Key_T, [this] { ask_for_place(); });
    add(show, "Show the whole scene", Qt::Key_0, [this] { show_scene(); });
}

void PalpationWindow::open(
    datasets::PalpationScene scene, const planner::PalpationSetup& setup, std::vector<std::string> notes)
{
    scene_ = std::move(scene);
    scene_notes_ = std::move(notes);
    wound_.reset();
    begin(setup);
}

void PalpationWindow::open_through(ShownWound wound, const planner::PalpationSetup& setup)
{
    scene_ = std::move(wound.palpable.scene);
    scene_notes_ = std::move(wound.palpable.notes);
    wound_ = std::move(wound);
    begin(setup);
}

void PalpationWindow::begin(const planner::PalpationSetup& setup)
{
    tool_->touch(nullptr, 0, 1.0);
    view_->set_live(nullptr);
    picture_.reset();
    surface_.reset();
    frame_ = nullptr;
    worker_.reset();
    snapshot_ = std::make_shared<const planner::PalpationSnapshot>();
    answers_ = 0;
    mark_.reset();
    grips_ = {};
    reach_said_.clear();
    reach_->clear();
    reach_->setVisible(wound_.has_value());
    say({}, false);
    const double radius = planner::fingertip_radius(scene_);
    panel_->begin(setup, kPressShare * radius, 3.0 * radius);
    setWindowTitle(translated(wound_ ? "Retractor - palpation through the wound: " + scene_.name
                                     : "Retractor - palpation of " + scene_.name));
    planner::PalpationBackend backend = backend_;
    if (wound_)
        backend.ways = wound_->ways;
    panel_->show_ways(backend.ways);
    worker_ = std::make_unique<planner::PalpationWorker>(scene_, setup, std::move(backend));
    show_scene();
    view_->show_note("Preparing the tissue …");
    poll_timer_.start();
}

void PalpationWindow::open_file(const std::filesystem::path& path)
{
    try {
        open(datasets::read_palpation_scene(path));
    } catch (...) {
        const std::string why = to_string(with_controls(current_failure()));
        say(why, true);
        if (worker_ == nullptr)
            view_->show_note(QString::fromStdString(why));
    }
}

void PalpationWindow::show_scene()
{
    try {
        // Behind moving tissue no full picture follows.
        view_->set_coarse_triangles(wound_ ? kWoundTriangles : PictureView::kCoarseTriangles);
        view_->show_scenes({ wound_ ? wound_->scene : palpation_scene(scene_, {}) });
    } catch (...) {
        say(to_string(with_controls(current_failure())), true);
    }
}

bool PalpationWindow::idle() const
{
    if (worker_ == nullptr)
        return true;
    const auto now = worker_->snapshot();
    return now->phase != planner::PalpationSnapshot::Phase::preparing && !now->busy && snapshot_->phase == now->phase
        && snapshot_->answers == now->answers
        && (now->phase == planner::PalpationSnapshot::Phase::failed || frame_ != nullptr);
}

void PalpationWindow::poll()
{
    if (worker_ == nullptr)
        return;
    take_snapshot();
    if (snapshot_->phase == planner::PalpationSnapshot::Phase::ready && worker_->has_frame()) {
        frame_ = &worker_->frame();
        draw();
    }
}

void PalpationWindow::take_snapshot()
{
    const bool was_ready = snapshot_->phase == planner::PalpationSnapshot::Phase::ready;
    const std::string model = snapshot_->setup.model, through = snapshot_->setup.through;
    snapshot_ = worker_->snapshot();
    if (std::exchange(answers_, snapshot_->answers) != snapshot_->answers)
        say(snapshot_->answer, snapshot_->refused);
    panel_->show_snapshot(*snapshot_, scene_notes_);
    switch (snapshot_->phase) {
    case planner::PalpationSnapshot::Phase::preparing:
        view_->show_note("Preparing the tissue"
            + (snapshot_->stage.empty() ? QString(" …")
                                        : QString(": %1 %2 %")
                                              .arg(QString::fromStdString(stage_in_words(snapshot_->stage)))
                                              .arg(static_cast<int>(100.0 * snapshot_->fraction))));
        return;
    case planner::PalpationSnapshot::Phase::failed:
        view_->show_note(QString::fromStdString(snapshot_->failure));
        say(snapshot_->failure, true);
        poll_timer_.stop();
        return;
    case planner::PalpationSnapshot::Phase::ready:
        break;
    }
    if (!snapshot_->busy)
        view_->show_note({});
    if (was_ready && model == snapshot_->setup.model) {
        if (through != snapshot_->setup.through)
            take_tool();
        return;
    }
    view_->set_live(nullptr);
    picture_ = std::make_unique<PalpationPicture>(scene_, snapshot_->abilities.organs);
    if (hands_)
        picture_->set_hands(*hands_);
    surface_.reset();
    grips_ = {};
    take_tool();
}

/// Gives the mouse the fingertips that the session has.
void PalpationWindow::take_tool()
{
    const double depth = panel_->depth().value(); // before the tool reports its own depth
    tool_->touch(worker_.get(), snapshot_->fingers, planner::fingertip_radius(scene_, access_in_hand()));
    tool_->set_depth(depth);
}

void PalpationWindow::show_hands(const ShownHands& hands)
{
    hands_ = hands;
    if (picture_ != nullptr)
        picture_->set_hands(*hands_);
    panel_->hands_box().setChecked(true);
}

void PalpationWindow::ask_for_hand()
{
    const QString file = QFileDialog::getOpenFileName(this, translated("Hand"), {}, "Wavefront OBJ (*.obj)");
    if (file.isEmpty())
        return;
    try {
        show_hands({ haptics::read_hand(file.toStdString(), false), haptics::read_hand(file.toStdString(), true) });
    } catch (...) {
        say(to_string(with_controls(current_failure())), true);
    }
}

PalpationViewOptions PalpationWindow::view_options() const
{
    PalpationViewOptions options;
    options.spheres = panel_->wants_spheres();
    options.hands = panel_->wants_hands();
    options.hidden_organs = panel_->hidden_organs();
    options.edits = snapshot_->edits;
    options.mark = mark_;
    for (std::size_t f = 0; f < planner::kMostFingers; ++f) {
        const bool mouse = f >= snapshot_->setup.devices.size() || snapshot_->setup.devices[f] == "mouse";
        options.fingers[f] = !mouse || tool_->is_out(f);
    }
    if (const haptics::FingerAccess* access = access_in_hand())
        options.through_opening = access->finger();
    if (view_->is_drawn()) {
        const Camera camera = view_->camera();
        options.sight = (camera.aim - camera.eye).normalized();
        options.up = camera.up;
    }
    return options;
}

void PalpationWindow::draw()
{
    if (frame_ == nullptr || picture_ == nullptr)
        return;
    if (surface_ != frame_->surface) {
        surface_ = frame_->surface;
        tool_->set_surface(surface_);
    }
    const PalpationViewOptions shown = view_options();
    try {
        const bool first = !view_->has_live();
        picture_->show(*frame_, shown);
        if (first)
            view_->set_live(&picture_->props());
    } catch (...) {
        say(to_string(with_controls(current_failure())), true);
        return;
    }
    view_->draw_soon();
    chart_->show_samples(
        frame_->strip, frame_->servo.finger_count, snapshot_->abilities.pulse, snapshot_->setup.force_gain);
    panel_->show_frame(*frame_, tool_->finger(), shown.fingers);
    show_reach();
}

QString PalpationWindow::reach_text() const { return reach_->isHidden() ? QString() : reach_->text(); }

const haptics::FingerAccess* PalpationWindow::access_in_hand() const
{
    if (!wound_ || wound_->ways.empty())
        return nullptr;
    const auto way = std::ranges::find(wound_->ways, snapshot_->setup.through, &planner::ThroughOpening::name);
    return (way != wound_->ways.end() ? *way : wound_->ways.front()).access.get();
}

void PalpationWindow::show_reach()
{
    const haptics::FingerAccess* access = access_in_hand();
    if (access == nullptr || frame_->reached == nullptr)
        return;
    const haptics::StraightRod& rod = access->finger();
    QString text = translated(formatted("A straight %s, %.0f mm thick and up to %.0f mm long, reaches %.0f %% of the "
                                        "whole surface shown here; what it does not reach is dark.",
        snapshot_->setup.through.c_str(), rod.thickness_mm, rod.reach_mm, 100.0 * frame_->reached_share));
    const haptics::FingerContact& contact = frame_->servo.contacts[tool_->finger()];
    if (tool_->is_out(tool_->finger()) && contact.stopped) {
        const auto& names = access->around().names();
        if (contact.stopped_by == haptics::FingerAccess::kTooFar)
            text += " " + translated("It is too short for this place.");
        else if (contact.stopped_by == haptics::FingerAccess::kStructure)
            text += " " + translated("What it should touch lies in its way.");
        else if (contact.stopped_by >= 0 && static_cast<std::size_t>(contact.stopped_by) < names.size())
            text += " " + translated("It is stopped by: " + names[static_cast<std::size_t>(contact.stopped_by)] + ".");
    }
    if (std::exchange(reach_said_, text) != text)
        reach_->setText(text);
}

void PalpationWindow::take_finger(std::size_t finger) { tool_->take_finger(finger); }

void PalpationWindow::lift_all()
{
    for (std::size_t f = 0; f < planner::kMostFingers; ++f)
        if (std::exchange(grips_[f], false) && worker_ != nullptr)
            worker_->run(planner::palpation::Grip { f, false });
    tool_->ask_for_place(nullptr);
    tool_->lift_all();
}

void PalpationWindow::ask_for_place()
{
    if (worker_ == nullptr || !snapshot_->abilities.edits)
        return;
    say("Click on the tissue to place the centre of the template", false);
    tool_->ask_for_place([this](const planner::SurfacePlace& place) { place_template(place.point); });
}

void PalpationWindow::place_template(const Vec3& centre)
{
    mark_ = panel_->chosen_template();
    mark_->centre = centre;
    panel_->set_edit_place(true);
    say({}, false);
    draw();
}

void PalpationWindow::apply_template()
{
    if (worker_ == nullptr || !mark_)
        return;
    haptics::ElasticTemplate edit = panel_->chosen_template();
    edit.centre = mark_->centre;
    worker_->run(planner::palpation::EditTissue { edit });
}

void PalpationWindow::start_recording()
{
    if (worker_ != nullptr)
        worker_->run(planner::palpation::StartRecording {});
}

void PalpationWindow::stop_recording(const std::filesystem::path& path)
{
    if (worker_ != nullptr)
        worker_->run(planner::palpation::StopRecording { path });
}

void PalpationWindow::record_or_stop()
{
    if (frame_ == nullptr)
        return;
    if (frame_->recorded_s < 0.0 && !snapshot_->unwritten_recording)
        return start_recording();
    const QString file = QFileDialog::getSaveFileName(this, translated("Save the recording"), "palpation.motion",
        translated("Motion (*.motion);;Motion as CSV (*.csv)"));
    if (!file.isEmpty())
        stop_recording(file.toStdString());
}

void PalpationWindow::ask_for_scene()
{
    const QString file = QFileDialog::getOpenFileName(
        this, translated("Open palpation scene"), {}, translated("Palpation scene (*.json)"));
    if (!file.isEmpty())
        open_file(file.toStdString());
}

void PalpationWindow::say(const std::string& text, bool refused)
{
    error_ = refused ? text : std::string();
    message_->setStyleSheet(refused ? "color: #ff8a80;" : "");
    message_->setText(translated(text));
    message_->setToolTip(message_->text());
}

void PalpationWindow::save_screenshot(const std::filesystem::path& path)
{
    view_->picture();
    write_png_file(path, grab().toImage());
}

} // namespace retractor::ui
