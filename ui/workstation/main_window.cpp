#include "ui/workstation/main_window.h"

#include "datasets/phantoms/palpation_scene_file.h"
#include "mesh/base/error.h"
#include "planner/case/case_io.h"
#include "planner/case/patient.h"
#include "planner/palpation/palpable.h"
#include "ui/scene/linked_slices.h"
#include "ui/workstation/planning/approach_list.h"
#include "ui/workstation/planning/metrics_panel.h"
#include "ui/workstation/view/picture_view.h"
#include "ui/workstation/view/png_file.h"
#include "ui/workstation/view/theme.h"

#include <QActionGroup>
#include <QCloseEvent>
#include <QFileDialog>
#include <QInputDialog>
#include <QLabel>
#include <QMenuBar>
#include <QMessageBox>
#include <QProgressBar>
#include <QPushButton>
#include <QSplitter>
#include <QStatusBar>
#include <QTabWidget>
#include <QToolBar>
#include <QVBoxLayout>

#include <algorithm>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr int kProgressMs = 100;
    constexpr int kProgressSteps = 1000;

    QWidget* titled(const QString& title, QWidget* content)
    {
        auto* pane = new QWidget;
        auto* column = new QVBoxLayout(pane);
        column->setContentsMargins(0, 0, 0, 0);
        column->setSpacing(0);
        auto* head = new QLabel(title);
        head->setStyleSheet(QString(kFaint) + " background: #262b30; padding: 8px 12px; font-weight: bold;");
        column->addWidget(head);
        column->addWidget(content, 1);
        return pane;
    }

} // namespace

MainWindow::MainWindow(BackendFactory factory, QWidget* parent)
    : QMainWindow(parent)
    , factory_(std::move(factory))
{
    setWindowTitle("Retractor");
    resize(1280, 860);
    make_panes();
    make_knife();
    make_actions();
    make_status_line();
    progress_timer_.setInterval(kProgressMs);
    connect(&progress_timer_, &QTimer::timeout, this, [this] { show_progress(); });
    show_all();
}

MainWindow::~MainWindow()
{
    planning_executor_.cancel(); // planning stops while the knife ends
}

void MainWindow::closeEvent(QCloseEvent* event)
{
    if (model_ && model_->busy()) {
        QMessageBox question(QMessageBox::Question, "Close the window?",
            "A plan is being calculated. If you close the window now, the plan ends and its result is lost.",
            QMessageBox::NoButton, this);
        QPushButton* const close = question.addButton("Close", QMessageBox::DestructiveRole);
        question.setDefaultButton(question.addButton("Go on planning", QMessageBox::RejectRole));
        question.exec();
        if (question.clickedButton() != close)
            return event->ignore();
    }
    knife_->abandon();
    if (model_)
        model_->cancel();
    planning_executor_.cancel();
    event->accept();
}

void MainWindow::make_panes()
{
    list_ = new ApproachList;
    view_ = new PictureView;
    panel_ = new MetricsPanel;
    view_->on_drawing_error = [this] { show_error({ view_->drawing_errors(), "drawing" }); };
    view_->on_slice_point = [this](const Vec3& point) { move_slices(point); };
    auto* panes = new QSplitter;
    panes->addWidget(titled("Approaches", list_));
    panes->addWidget(view_);
    knife_panel_ = new KnifePanel;
    tabs_ = new QTabWidget;
    tabs_->setDocumentMode(true);
    tabs_->addTab(panel_, "Numbers");
    tabs_->addTab(knife_panel_, "Knife");
    panes->addWidget(tabs_);
    panes->setHandleWidth(2);
    panes->setChildrenCollapsible(false);
    panes->setSizes({ 230, 750, 300 });
    panes->setStretchFactor(0, 0);
    panes->setStretchFactor(1, 1);
    panes->setStretchFactor(2, 0);
    setCentralWidget(panes);
    connect(list_, &QListWidget::currentRowChanged, this, [this](int row) {
        if (row < 0)
            return;
        model_->select(static_cast<std::size_t>(row));
        hand_out_work();
        show_all();
    });
    connect(list_, &QListWidget::itemActivated, this, [this] { plan_selected(); });
}

void MainWindow::make_knife()
{
    knife_ = std::make_unique<KnifeTool>(*view_, *knife_panel_);
    knife_->on_change = [this] { show_all(); };
    knife_->on_answer = [this](const std::string& text, bool refused) {
        if (refused)
            show_error({ text, "knife" });
        else if (text.empty())
            clear_error();
        else
            show_message(QString::fromStdString(text));
    };
    knife_panel_->on_export = [this] { ask_for_export_file(); };
    connect(tabs_, &QTabWidget::currentChanged, this, [this] {
        if (!knife_tab_open())
            knife_->set_mode(KnifeMode::away);
        show_all();
    });
}

bool MainWindow::knife_tab_open() const { return tabs_->currentWidget() == knife_panel_; }

void MainWindow::set_knife(KnifeMode mode)
{
    if (!model_ || !model_->selected())
        mode = KnifeMode::away;
    knife_->set_mode(mode);
    if (mode != KnifeMode::away)
        tabs_->setCurrentWidget(knife_panel_);
    show_all();
}

void MainWindow::show_knife()
{
    if (model_ && model_->selected() && knife_tab_open()) {
        const std::size_t index = *model_->selected();
        knife_->set_up(index, [make = backend_.surgery_input, approach = model_->approach(index)](const Job& job) {
            return make(approach, job);
        });
    } else {
        knife_->leave();
    }
    const planner::SurgerySnapshot* snapshot = knife_->snapshot();
    knife_action_->setEnabled(model_ && model_->selected());
    line_action_->setEnabled(knife_action_->isEnabled());
    knife_action_->setChecked(knife_->mode() == KnifeMode::freehand);
    hook_action_->setEnabled(knife_action_->isEnabled());
    hook_action_->setChecked(knife_->mode() == KnifeMode::hooks);
    line_action_->setChecked(knife_->mode() == KnifeMode::line);
    take_out_action_->setEnabled(knife_action_->isEnabled());
    take_out_action_->setChecked(knife_->mode() == KnifeMode::take_out);
    undo_->setEnabled(snapshot != nullptr && snapshot->can_undo);
    redo_->setEnabled(snapshot != nullptr && snapshot->can_redo);
}

void MainWindow::make_knife_actions(QMenu& menu, QToolBar& bar)
{
    const auto add = [&](const QString& text, const QKeySequence& key, const QString& tip, auto run) {
        QAction* action = menu.addAction(text);
        action->setShortcut(key);
        action->setToolTip(tip + " (" + key.toString(QKeySequence::NativeText) + ")");
        connect(action, &QAction::triggered, this, run);
        return action;
    };
    const auto add_mode
        = [&](QAction*& action, const QString& text, const QKeySequence& key, const QString& tip, KnifeMode mode) {
              action = add(
                  text, key, tip, [this, mode, &action] { set_knife(action->isChecked() ? mode : KnifeMode::away); });
              action->setCheckable(true);
          };
    add_mode(knife_action_, "Knife", Qt::Key_K, "Draw cuts on the skin with the left button", KnifeMode::freehand);
    add_mode(line_action_, "Line", Qt::Key_L, "Cut straight between two clicks", KnifeMode::line);
    add_mode(hook_action_, "Hooks", Qt::Key_H, "Press on the edge of a wound to set a hook; drag a hook to pull it",
        KnifeMode::hooks);
    add_mode(take_out_action_, "Take out", Qt::Key_X, "Press on a loose piece or on tissue to remove it",
        KnifeMode::take_out);
    undo_
        = add("Undo cut", QKeySequence::Undo, "Undo the last cut", [this] { knife_->run(planner::surgery::Undo {}); });
    redo_ = add(
        "Redo cut", QKeySequence("Ctrl+Shift+Z"), "Redo the cut", [this] { knife_->run(planner::surgery::Redo {}); });
    undo_->setIconText("Undo"); // all tools fit into 1280 px
    redo_->setIconText("Redo");
    bar.addActions({ knife_action_, line_action_, hook_action_, take_out_action_, undo_, redo_ });
}

void MainWindow::make_actions()
{
    QToolBar* bar = addToolBar("Tools");
    bar->setMovable(false);
    bar->setContextMenuPolicy(Qt::PreventContextMenu);
    QMenu* file = menuBar()->addMenu("&File");
    QMenu* view = menuBar()->addMenu("&View");
    QMenu* plan = menuBar()->addMenu("&Plan");
    QMenu* knife = menuBar()->addMenu("&Knife");
    QMenu* help = menuBar()->addMenu("&Help");

    const auto add = [this](QMenu* menu, const QString& text, const QKeySequence& key, const QString& tip, auto run) {
        QAction* action = menu->addAction(text);
        action->setShortcut(key);
        action->setToolTip(key.isEmpty() ? tip : tip + " (" + key.toString(QKeySequence::NativeText) + ")");
        connect(action, &QAction::triggered, this, run);
        return action;
    };
    QAction* open = add(file, "Open case…", QKeySequence::Open, "Open a case.json", [this] { ask_for_case(); });
    save_
        = add(file, "Save picture…", QKeySequence::Save, "Save the picture as PNG", [this] { ask_for_picture_file(); });
    palpate_ = add(file, "Palpate a structure…", {}, "Palpate a vessel or an organ of this case in a new window",
        [this] { ask_for_structure(); });
    file->addSeparator();
    add(file, "Quit", QKeySequence::Quit, "Close the window", [this] { close(); });

    surgeon_
        = add(view, "Surgeon's eye", Qt::Key_1, "View through the incision", [this] { set_view(ViewPreset::surgeon); });
    overview_ = add(
        view, "Overview", Qt::Key_2, "View of the patient from outside", [this] { set_view(ViewPreset::overview); });
    slices_ = add(
        view, "Slices", Qt::Key_3, "Three planes of the CT and the overview", [this] { set_view(ViewPreset::slices); });
    auto* presets = new QActionGroup(this);
    for (QAction* action : { surgeon_, overview_, slices_ }) {
        action->setCheckable(true);
        presets->addAction(action);
    }
    view->addSeparator();
    grey_windows_ = new QActionGroup(this);
    for (std::size_t i = 0; i < kGreyWindows.size(); ++i) {
        const GreyWindow& grey = kGreyWindows[i];
        QAction* action = add(view, grey.name, QKeySequence("Shift+" + QString::number(i + 1)),
            QString("Slices from %1 to %2 HU")
                .arg(grey.level_hu - 0.5 * grey.window_hu)
                .arg(grey.level_hu + 0.5 * grey.window_hu),
            [this, i] { set_grey_window(i); });
        action->setCheckable(true);
        grey_windows_->addAction(action);
    }
    view->addSeparator();
    opened_ = add(view, "Opened", Qt::Key_O, "Switch between the opened field and the patient before the cut", [this] {
        model_->set_show_opened(opened_->isChecked());
        show_picture();
    });
    opened_->setCheckable(true);

    plan_ = add(plan, "Plan", Qt::Key_P, "Cut, open and measure this approach", [this] { plan_selected(); });
    plan_all_ = add(
        plan, "Plan all", QKeySequence("Shift+P"), "Cut, open and measure all approaches", [this] { plan_all(); });
    cancel_ = add(plan, "Cancel", Qt::Key_Escape, "Discard the open stroke, or stop planning", [this] { cancel(); });
    add(help, "About Retractor", {}, "Show the version and the licence", [this] { show_about(); });

    open->setIconText("Open…");
    save_->setIconText("Save…");
    bar->addAction(open);
    bar->addSeparator();
    int key = 1;
    for (QAction* action : { surgeon_, overview_, slices_ })
        action->setIconText(QString::number(key++) + "  " + action->text());
    bar->addActions({ surgeon_, overview_, slices_ });
    bar->addSeparator();
    bar->addAction(opened_);
    bar->addSeparator();
    bar->addActions({ plan_, plan_all_ });
    bar->addSeparator();
    make_knife_actions(*knife, *bar);
    bar->addSeparator();
    bar->addAction(save_);
}

void MainWindow::make_status_line()
{
    message_ = add_message(*statusBar());
    progress_ = new QProgressBar;
    progress_->setRange(0, kProgressSteps);
    progress_->setFixedWidth(300);
    cancel_button_ = new QPushButton("Cancel");
    connect(cancel_button_, &QPushButton::clicked, this, [this] { cancel(); });
    statusBar()->addPermanentWidget(progress_);
    statusBar()->addPermanentWidget(cancel_button_);
    add_notice(*statusBar());
}

void MainWindow::open(planner::Case planned_case)
{
    cancel();
    knife_->clear();
    ++generation_;
    closed_running_ = 0;
    plans_running_ = 0;
    const ViewPreset view = model_ ? model_->view() : ViewPreset::surgeon;
    backend_ = factory_(planned_case);
    const std::size_t grey_window = model_ ? model_->grey_window() : 0;
    model_ = std::make_unique<SessionModel>(std::move(planned_case));
    model_->set_view(view);
    model_->set_grey_window(grey_window);
    const planner::Case& shown = model_->planned_case();
    const std::filesystem::path name = shown.file_name == planner::kCaseFileName
        ? shown.folder.filename()
        : shown.folder.filename() / shown.file_name;
    setWindowTitle("Retractor - " + QString::fromStdString(name.string()));
    clear_error();
    hand_out_work();
    show_all();
}

/// Called on the reading executor's thread.
void MainWindow::reading_failed(const Failure& failure)
{
    post_back([this, failure] {
        --reading_;
        show_all();
        show_error(failure);
    });
}

void MainWindow::open_file(const std::filesystem::path& path)
{
    if (on_palpation_scene && datasets::is_palpation_scene(path))
        return on_palpation_scene(path);
    ++reading_;
    view_->show_note("Reading " + QString::fromStdString(path.string()) + " …");
    reading_executor_.post([this, path](const Job&) {
        try {
            auto planned_case = std::make_shared<planner::Case>(planner::read_case(path));
            post_back([this, planned_case] {
                --reading_;
                open(std::move(*planned_case));
            });
        } catch (const Error& error) {
            reading_failed(case_failure(path, error));
        } catch (...) {
            reading_failed(with_controls(current_failure()));
        }
    });
}

void MainWindow::palpate(const std::string& structure)
{
    ++reading_;
    clear_error();
    show_message(QString("Preparing %1 for palpation …").arg(QString::fromStdString(structure)));
    reading_executor_.post([this, structure, patient_case = model_->planned_case()](const Job&) {
        try {
            planner::Patient patient(patient_case);
            planner::PalpableRequest request;
            request.structure = { structure };
            auto made = std::make_shared<planner::Palpable>(planner::make_palpable(patient, request));
            post_back([this, made] {
                --reading_;
                clear_error();
                show_all();
                if (on_palpable)
                    on_palpable(std::move(*made));
            });
        } catch (...) {
            reading_failed(with_controls(current_failure()));
        }
    });
}

void MainWindow::select(const std::string& approach)
{
    model_->select(approach);
    hand_out_work();
    show_all();
}

void MainWindow::set_view(ViewPreset view)
{
    if (!model_ || !model_->view_available(view))
        return;
    model_->set_view(view);
    show_all();
}

void MainWindow::plan_selected()
{
    if (!model_ || !model_->selected())
        return;
    clear_error();
    tabs_->setCurrentWidget(panel_);
    model_->request_plan(*model_->selected());
    hand_out_work();
    show_all();
}

void MainWindow::plan_all()
{
    if (!model_)
        return;
    clear_error();
    tabs_->setCurrentWidget(panel_);
    for (std::size_t index = 0; index < model_->approach_count(); ++index)
        model_->request_plan(index);
    hand_out_work();
    show_all();
}

void MainWindow::cancel()
{
    if (knife_->abandon())
        return;
    if (!model_)
        return;
    model_->cancel();
    planning_executor_.cancel();
    show_all();
}

bool MainWindow::idle() const { return reading_ == 0 && closed_running_ == 0 && plans_running_ == 0 && knife_->idle(); }

void MainWindow::hand_out_work()
{
    if (const auto index = model_->begin_closed())
        make_closed(*index);
    if (const auto index = model_->begin_plan())
        make_plan(*index);
}

void MainWindow::make_closed(std::size_t index)
{
    ++closed_running_;
    closed_executor_.post(
        [this, generation = generation_, backend = backend_, approach = model_->approach(index)](const Job&) {
            std::function<void()> deliver;
            try {
                auto pictures = std::make_shared<ClosedPictures>(backend.closed_pictures(approach, Job {}));
                deliver = [this, pictures] { model_->closed_done(std::move(*pictures)); };
            } catch (...) {
                deliver = [this, failure = with_controls(current_failure())] {
                    model_->closed_failed(failure);
                    show_error(failure);
                };
            }
            post_back(generation, [this, deliver] {
                --closed_running_;
                deliver();
                hand_out_work();
                show_all();
            });
        });
}

void MainWindow::make_plan(std::size_t index)
{
    ++plans_running_;
    planning_executor_.post(
        [this, generation = generation_, backend = backend_, approach = model_->approach(index)](const Job& job) {
            std::function<void()> deliver;
            try {
                job.report("begin", 0.0);
                auto outcome = std::make_shared<PlanOutcome>(backend.plan(approach, job));
                deliver = [this, outcome, name = approach.name] {
                    switch (outcome->status) {
                    case PlanOutcome::Status::planned:
                        model_->plan_done(std::move(outcome->field));
                        return;
                    case PlanOutcome::Status::cancelled:
                        model_->plan_cancelled();
                        return;
                    case PlanOutcome::Status::refused:
                        break;
                    }
                    model_->plan_failed({ outcome->message, "approach " + name });
                    show_error({ outcome->message, "approach " + name });
                };
            } catch (...) {
                deliver = [this, failure = with_controls(current_failure())] {
                    model_->plan_failed(failure);
                    show_error(failure);
                };
            }
            post_back(generation, [this, deliver] {
                --plans_running_;
                deliver();
                hand_out_work();
                show_all();
            });
        });
}

void MainWindow::post_back(std::function<void()> deliver)
{
    QMetaObject::invokeMethod(this, std::move(deliver), Qt::QueuedConnection);
}

void MainWindow::post_back(int generation, std::function<void()> deliver)
{
    post_back([this, generation, deliver = std::move(deliver)] {
        if (generation == generation_)
            deliver();
    });
}

void MainWindow::show_all()
{
    if (model_)
        list_->show_model(*model_);
    panel_->show_model(model_.get());
    show_knife();
    const bool any = model_ && model_->selected();
    const ApproachState* state = any ? &model_->state(*model_->selected()) : nullptr;
    surgeon_->setEnabled(any);
    overview_->setEnabled(any);
    slices_->setEnabled(any && model_->view_available(ViewPreset::slices));
    if (model_) {
        surgeon_->setChecked(model_->view() == ViewPreset::surgeon);
        overview_->setChecked(model_->view() == ViewPreset::overview);
        slices_->setChecked(model_->view() == ViewPreset::slices);
    }
    grey_windows_->setEnabled(slices_->isEnabled());
    grey_windows_->actions().at(static_cast<int>(model_ ? model_->grey_window() : 0))->setChecked(true);
    opened_->setEnabled(any && state->field != nullptr);
    opened_->setChecked(opened_->isEnabled() && model_->show_opened());
    plan_->setEnabled(any && (state->status == FieldStatus::closed || state->status == FieldStatus::failed));
    plan_all_->setEnabled(any);
    save_->setEnabled(any);
    palpate_->setEnabled(model_ != nullptr && static_cast<bool>(on_palpable));
    show_progress();
    show_picture();
}

void MainWindow::show_picture()
{
    if (!model_) {
        view_->show_note(reading_ > 0 ? "Reading …" : "Open a case to begin: File, Open case");
        return;
    }
    const std::shared_ptr<const Scene> by_hand = knife_->scene();
    ShownSource source = model_->shown_source();
    if (by_hand != nullptr)
        source = { .pictures = by_hand, .opened = false, .view = model_->view(), .approach = model_->selected() };
    view_->show_note(
        source.pictures == nullptr && closed_running_ > 0 ? "Reading the patient …" : knife_->waiting_for());
    if (source == shown_)
        return;
    try {
        std::vector<Scene> scenes
            = by_hand != nullptr ? std::vector<Scene> { knife_scene(*by_hand, source) } : model_->shown_scenes();
        shown_ = std::move(source);
        view_->show_scenes(std::move(scenes));
    } catch (...) {
        show_error(with_controls(current_failure()));
    }
    if (const std::string errors = view_->drawing_errors(); !errors.empty())
        show_error({ errors, "drawing" });
}

void MainWindow::move_slices(const Vec3& point)
{
    if (!slices_shown())
        return;
    model_->set_slice_point(point);
    show_slices();
}

void MainWindow::set_grey_window(std::size_t index)
{
    if (!model_)
        return;
    model_->set_grey_window(index);
    if (slices_shown())
        show_slices();
}

/// Whether the picture is that of the slices, and not that of the knife.
bool MainWindow::slices_shown() const
{
    return model_ && model_->view() == ViewPreset::slices && shown_ == model_->shown_source()
        && shown_.pictures != nullptr;
}

/// Shows the slices anew, each from where it is seen now.
void MainWindow::show_slices()
{
    try {
        const std::vector<Scene> scenes = model_->shown_scenes();
        for (std::size_t i = 0; i < std::min(scenes.size(), view_->scenes().size()); ++i)
            if (is_linked_slice(scenes[i]) && is_linked_slice(view_->scenes()[i]))
                view_->replace_scene(i, scenes[i]);
    } catch (...) {
        show_error(with_controls(current_failure()));
    }
}

/// The scene for the knife. The camera stays in place when only the knife was taken or put away.
Scene MainWindow::knife_scene(const Scene& surroundings, const ShownSource& source) const
{
    Scene scene = surroundings;
    scene.lines.clear(); // the tool draws the planned incision until hooks hold the wound open
    const bool in_space = view_->scenes().size() == 1 && view_->scenes().front().slices.empty();
    if (in_space && shown_.pictures != nullptr && shown_.view == source.view && shown_.approach == source.approach)
        scene.camera = view_->camera();
    else if (source.view == ViewPreset::surgeon)
        scene.camera = surgeon_camera(model_->approach(*model_->selected()), scene.camera.up);
    return scene;
}

void MainWindow::show_progress()
{
    const bool busy = model_ && model_->busy();
    cancel_->setEnabled(busy || knife_->mode() != KnifeMode::away);
    progress_->setVisible(busy);
    cancel_button_->setVisible(busy);
    if (!busy) {
        progress_timer_.stop();
        return;
    }
    progress_timer_.start();
    const std::size_t index = *model_->planning();
    const bool cancelling = model_->state(index).status == FieldStatus::cancelling;
    cancel_button_->setEnabled(!cancelling);
    const SerialExecutor::Progress planning = planning_executor_.progress();
    progress_->setValue(static_cast<int>(kProgressSteps * planning.fraction));
    progress_->setFormat(
        QString::fromStdString(model_->approach(index).name + ": " + (cancelling ? "cancelling" : planning.stage)));
}

void MainWindow::show_error(const Failure& failure)
{
    error_ = to_string(failure);
    message_->setStyleSheet("color: #ff8a80;");
    message_->setText(QString::fromStdString(error_));
    message_->setToolTip(message_->text());
}

void MainWindow::show_message(const QString& text)
{
    clear_error();
    message_->setStyleSheet({});
    message_->setText(text);
}

std::string MainWindow::message_line() const { return message_->text().toStdString(); }

void MainWindow::clear_error()
{
    error_.clear();
    message_->clear();
    message_->setToolTip({});
}

void MainWindow::save_picture(const std::filesystem::path& path) { write_png_file(path, view_->picture()); }

void MainWindow::save_screenshot(const std::filesystem::path& path)
{
    view_->picture();
    write_png_file(path, grab().toImage());
}

void MainWindow::ask_for_case()
{
    const QString file = QFileDialog::getOpenFileName(this, "Open case", {}, "Case (case.json *.json)");
    if (!file.isEmpty())
        open_file(file.toStdString());
}

void MainWindow::ask_for_structure()
{
    if (!model_)
        return;
    QStringList names;
    int vessel = 0;
    for (const mesh::LabelInfo& info : model_->planned_case().label_table) {
        if (info.material == "vessel" && vessel == 0)
            vessel = static_cast<int>(names.size());
        names += QString::fromStdString(info.name);
    }
    bool chosen = false;
    const QString name = QInputDialog::getItem(this, "Palpate",
        "Structure to palpate (a vessel gets a wall of 2 mm, filled with blood):", names, vessel, false, &chosen);
    if (chosen)
        palpate(name.toStdString());
}

void MainWindow::ask_for_picture_file()
{
    QString file = QFileDialog::getSaveFileName(this, "Save picture", "picture.png", "Picture (*.png)");
    if (file.isEmpty())
        return;
    if (!file.endsWith(".png", Qt::CaseInsensitive))
        file += ".png";
    try {
        save_picture(file.toStdString());
        show_message("Saved " + file);
    } catch (...) {
        show_error(with_controls(current_failure()));
    }
}

void MainWindow::ask_for_export_file()
{
    QString file = QFileDialog::getSaveFileName(this, "Export the cut wall", "cut-wall.vtu", "Mesh (*.vtu)");
    if (file.isEmpty())
        return;
    if (!file.endsWith(".vtu", Qt::CaseInsensitive))
        file += ".vtu";
    knife_->run(planner::surgery::ExportWall { file.toStdString() });
}

void MainWindow::show_about()
{
    QMessageBox::about(this, "About Retractor",
        "<h3>Retractor " RETRACTOR_VERSION "</h3>"
        "<p>A surgical incision planning workstation: draw the incision, open it with hooks, see what the surgeon will "
        "see.</p>"
        "<p><b>Not a medical device.</b> The pictures and numbers come from a model with assumed tissue properties. "
        "They are for "
        "research and teaching and must not be used to treat a patient.</p>"
        "<p>Free software under the GPL, version 3 or later.</p>");
}

} // namespace retractor::ui
