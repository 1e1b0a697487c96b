#include "ui/workstation/main_window.h"

#include "datasets/phantoms/aorta_phantom.h"
#include "datasets/phantoms/palpation_scene_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/demo_patient.h"
#include "planner/case/case_io.h"
#include "planner/case/import_case.h"
#include "planner/case/patient.h"
#include "planner/palpation/palpable.h"
#include "ui/scene/linked_slices.h"
#include "ui/workstation/conference/notes_window.h"
#include "ui/workstation/help/manual_window.h"
#include "ui/workstation/labels/label_editor.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/language/stage_words.h"
#include "ui/workstation/planning/approach_list.h"
#include "ui/workstation/planning/metrics_panel.h"
#include "ui/workstation/planning/search_dialog.h"
#include "ui/workstation/start/case_folder.h"
#include "ui/workstation/start/case_lock.h"
#include "ui/workstation/start/import_dialog.h"
#include "ui/workstation/start/recent_cases.h"
#include "ui/workstation/start/start_page.h"
#include "ui/workstation/view/banner.h"
#include "ui/workstation/view/controls.h"
#include "ui/workstation/view/picture_view.h"
#include "ui/workstation/view/step_bar.h"
#include "ui/workstation/view/theme.h"

#include <QActionGroup>
#include <QCloseEvent>
#include <QCoreApplication>
#include <QDialog>
#include <QDragEnterEvent>
#include <QDropEvent>
#include <QFileDialog>
#include <QGridLayout>
#include <QInputDialog>
#include <QLabel>
#include <QMessageBox>
#include <QMimeData>
#include <QProgressBar>
#include <QPushButton>
#include <QSplitter>
#include <QStackedWidget>
#include <QStatusBar>
#include <QTabWidget>
#include <QVBoxLayout>

#include <algorithm>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr int kProgressMs = 100;
    constexpr int kProgressSteps = 1000;

    /// When the file was changed last; nothing when there is no such file.
    std::optional<std::filesystem::file_time_type> time_of(const std::filesystem::path& file)
    {
        std::error_code code;
        const auto time = std::filesystem::last_write_time(file, code);
        return code ? std::nullopt : std::optional(time);
    }

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
    setAcceptDrops(true);
    make_panes();
    make_start_page();
    make_knife();
    make_editor();
    make_labels();
    make_conference();
    make_tour();
    measure_tool_ = std::make_unique<ClickTool>([this](const QPointF& at) { measure_at(at); });
    make_actions();
    make_status_line();
    progress_timer_.setInterval(kProgressMs);
    connect(&progress_timer_, &QTimer::timeout, this, [this] { show_progress(); });
    translate_texts(*this);
    show_all();
}

MainWindow::~MainWindow()
{
    planning_executor_.cancel(); // planning stops while the knife ends
}

bool MainWindow::may_lose(const QString& question_text, const QString& what, const QString& go_on)
{
    QMessageBox question(
        QMessageBox::Question, translated(question_text), translated(what), QMessageBox::NoButton, this);
    QPushButton* const close = question.addButton(translated("Close"), QMessageBox::DestructiveRole);
    question.setDefaultButton(question.addButton(translated(go_on), QMessageBox::RejectRole));
    question.exec();
    return question.clickedButton() == close;
}

bool MainWindow::may_leave_case(const QString& question)
{
    if (model_ && model_->busy()
        && !may_lose(question, "A plan is being calculated. If you close now, the plan ends and its result is lost.",
            "Go on planning"))
        return false;
    if (labels_->changed()
        && !may_lose(
            question, "The corrected labels are not saved. If you close now, the corrections are lost.", "Go back"))
        return false;
    if (search_dialog_ != nullptr && !search_dialog()->idle()
        && !may_lose(
            question, "A search for an incision is running. If you close now, its result is lost.", "Go on searching"))
        return false;
    if (knife_->would_lose_cuts()
        && !may_lose(question,
            QString::fromStdString(
                "The cuts by hand are not saved. If you close now, they are lost. " + knife_->cuts_not_saved()),
            "Go back"))
        return false;
    return not_saved_.empty()
        || may_lose(question,
            QString::fromStdString(
                "The approaches of this case are not saved. If you close now, they are lost. " + not_saved_),
            "Go back");
}

void MainWindow::closeEvent(QCloseEvent* event)
{
    if (exports_running_ > 0
        && !may_lose("Close the window?", "A file is being saved. If you close now, it is not saved.", "Go on saving"))
        return event->ignore();
    if (!may_leave_case("Close the window?"))
        return event->ignore();
    set_conference(false); // a note that is being written is kept
    knife_->abandon();
    if (model_)
        model_->cancel();
    planning_executor_.cancel();
    export_executor_.cancel();
    labels_->forget_unsaved(); // nothing unsaved, or lost as the user wants
    event->accept();
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event)
{
    if (event->mimeData()->hasUrls() && event->mimeData()->urls().size() == 1
        && event->mimeData()->urls().front().isLocalFile())
        event->acceptProposedAction();
}

/// Opens a case, or offers to import anything else.
void MainWindow::dropEvent(QDropEvent* event)
{
    const std::filesystem::path path = event->mimeData()->urls().front().toLocalFile().toStdString();
    std::error_code code;
    const bool is_case = path.extension() == ".json" || std::filesystem::exists(path / planner::kCaseFileName, code);
    event->acceptProposedAction();
    if (is_case)
        open_file(path);
    else
        import_study(path);
}

void MainWindow::make_panes()
{
    list_ = new ApproachList;
    view_ = new PictureView;
    panel_ = new MetricsPanel;
    panel_->on_compare = [this](std::size_t id, bool is_compared) { compare(id, is_compared); };
    view_->on_drawing_error = [this] { show_error({ view_->drawing_errors(), "drawing" }); };
    view_->on_slice_point = [this](const Vec3& point) { move_slices(point); };
    view_->on_space_click = [this](std::size_t scene, const planner::Ray& ray) { name_place(scene, ray); };
    view_->on_handle = [this](const Vec3& place, bool last) { drag_blade(place, last); };
    view_->on_cut_step = [this](double notches) { step_cut(notches); };
    view_->on_double_click = [this](std::size_t scene) { enlarge(scene); };
    view_->on_full_picture = [this](const QImage& picture) {
        if (!remembers_ || !model_ || !is_drawn_on(model_->shown_view()) || pictured_ == model_->planned_case().file())
            return;
        pictured_ = model_->planned_case().file();
        keep_case_picture(pictured_, picture);
    };
    auto* panes = new QSplitter;
    approach_pane_ = titled("Approaches", make_approach_pane());
    panes->addWidget(approach_pane_);
    panes->addWidget(view_);
    knife_panel_ = new KnifePanel;
    tabs_ = new QTabWidget;
    tabs_->setDocumentMode(true);
    tabs_->addTab(panel_, "Numbers");
    tabs_->addTab(knife_panel_, "Knife");
    label_panel_ = new LabelPanel;
    tabs_->addTab(label_panel_, "Labels");
    panes->addWidget(tabs_);
    panes->setHandleWidth(2);
    panes->setChildrenCollapsible(false);
    panes->setSizes({ 256, 724, 300 });
    panes->setStretchFactor(0, 0);
    panes->setStretchFactor(1, 1);
    panes->setStretchFactor(2, 0);
    not_saved_banner_ = new Banner("#7a2a2a");
    not_saved_banner_->on_button = [this] { save_case(changed_by_others_); };
    cuts_banner_ = new Banner("#7a2a2a");
    cuts_banner_->setObjectName("cuts not saved");
    cuts_banner_->on_button = [this] { knife_->save_cuts(); };
    looking_banner_ = new Banner("#2a4a6a");
    looking_banner_->on_button = [this] { open_file(model_->planned_case().file()); };
    auto* page = new QWidget;
    auto* column = new QVBoxLayout(page);
    column->setContentsMargins(0, 0, 0, 0);
    column->setSpacing(0);
    column->addWidget(not_saved_banner_);
    column->addWidget(cuts_banner_);
    column->addWidget(looking_banner_);
    column->addWidget(panes, 1);
    conference_bar_ = new StepBar;
    conference_bar_->hide();
    column->addWidget(conference_bar_);
    tour_bar_ = new StepBar;
    tour_bar_->set_large(false);
    tour_bar_->hide();
    column->addWidget(tour_bar_);
    pages_ = new QStackedWidget;
    pages_->addWidget(page);
    setCentralWidget(pages_);
    connect(list_, &QListWidget::currentRowChanged, this, [this](int row) {
        if (row < 0)
            return;
        editor_->abandon();
        model_->select(static_cast<std::size_t>(row));
        hand_out_work();
        show_all();
    });
    connect(list_, &QListWidget::itemActivated, this, [this] { plan_selected(); });
    connect(list_, &QListWidget::itemClicked, this, [this] { // leaves the comparison for this approach
        if (model_ && model_->view() == ViewPreset::compare)
            set_view(ViewPreset::surgeon);
    });
}

/// The list of approaches with the buttons that change it.
QWidget* MainWindow::make_approach_pane()
{
    auto* pane = new QWidget;
    auto* column = new QVBoxLayout(pane);
    column->setContentsMargins(0, 0, 0, 0);
    column->setSpacing(0);
    column->addWidget(list_, 1);
    approach_buttons_ = new QGridLayout;
    approach_buttons_->setContentsMargins(8, 8, 8, 8);
    approach_buttons_->setSpacing(4);
    column->addLayout(approach_buttons_);
    return pane;
}

void MainWindow::make_editor()
{
    editor_ = std::make_unique<ApproachEditor>(*view_, *this);
    editor_->on_edit = [this] {
        clear_error();
        std::vector<std::size_t> present;
        for (std::size_t index = 0; index < model_->approach_count(); ++index)
            present.push_back(model_->id(index));
        knife_->keep_only(present);
        hand_out_work();
        show_all();
        save_case();
    };
    editor_->on_state = [this] { show_all(); };
    editor_->on_wall_look = [this](WallLook look) { set_wall_look(look); };
    editor_->on_message = [this](const QString& text) { show_message(text); };
    editor_->on_failure = [this](const Failure& failure) {
        show_error(with_controls(failure));
        if (model_ && model_->view() == ViewPreset::incision)
            reset_view(); // a refused blade goes back
    };
}

void MainWindow::make_labels()
{
    labels_ = std::make_unique<LabelEditor>(*view_, *label_panel_, *this);
    labels_->present_case = [this] { return model_->planned_case(); };
    labels_->on_labels = [this] {
        show_corrected_labels();
        label_panel_->show_session(labels_->session(), {});
        if (slices_shown())
            show_slices();
        show_undo();
    };
    labels_->on_save = [this](const planner::Case& corrected, const std::shared_ptr<const mesh::LabelVolume>& labels) {
        save_labels(corrected, labels);
    };
    labels_->on_place = [this](const Vec3& place) { move_slices(place); };
    labels_->on_message = [this](const QString& text) { show_message(text); };
    labels_->on_failure = [this](const Failure& failure) { show_error(with_controls(failure)); };
}

/// Another program has changed the case: asks whether the labels go into the case as it is on disk now.
void MainWindow::put_labels_into_changed_case(const std::shared_ptr<const mesh::LabelVolume>& labels)
{
    QMessageBox question(QMessageBox::Question, translated("Save labels"),
        translated("Another program has changed the case meanwhile. Put the corrected labels into the case as it is "
                   "now? What you "
                   "changed in the approaches since then is not in it."),
        QMessageBox::NoButton, this);
    QPushButton* const put = question.addButton(translated("Put them in"), QMessageBox::AcceptRole);
    question.setDefaultButton(question.addButton(translated("Go back"), QMessageBox::RejectRole));
    question.exec();
    if (question.clickedButton() != put || labels_->session() == nullptr)
        return;
    try {
        const planner::Case present = planner::read_case(model_->planned_case().file());
        save_labels(labels_->session()->corrected(present), labels, true);
    } catch (...) {
        show_error(with_controls(current_failure()));
    }
}

/// Slices show the labels under correction while they are corrected, and until that is saved or discarded.
void MainWindow::show_corrected_labels()
{
    if (!model_)
        return;
    const bool wanted = labels_->session() != nullptr && (labels_tab_open() || labels_->changed());
    model_->set_corrected_labels(wanted ? labels_->session()->labels() : nullptr);
}

bool MainWindow::labels_tab_open() const { return tabs_->currentWidget() == label_panel_; }

void MainWindow::correct_labels()
{
    tabs_->setCurrentWidget(label_panel_);
    show_all();
}

void MainWindow::save_labels(
    const planner::Case& corrected, const std::shared_ptr<const mesh::LabelVolume>& labels, bool over_others)
{
    ++saving_;
    setEnabled(false); // what is edited meanwhile would belong to the labels before
    show_message("Saving the labels …");
    saving_executor_.post([this, corrected, labels, over_others, generation = generation_](const Job&) {
        auto saved = std::make_shared<planner::Case>();
        std::optional<Failure> failure;
        bool changed = false;
        try {
            const auto now = time_of(corrected.file());
            changed = !over_others && case_time_ && now && *now != *case_time_;
            if (changed)
                throw IoError("Another program has changed the case meanwhile.", corrected.file().string());
            *saved = planner::write_corrected_labels(corrected, *labels);
            case_time_ = time_of(saved->file());
        } catch (...) {
            failure = current_failure();
        }
        post_back([this, generation, saved, failure, changed, labels] {
            --saving_;
            setEnabled(true);
            if (generation != generation_)
                return;
            if (changed)
                return put_labels_into_changed_case(labels);
            if (failure)
                return show_error(*failure);
            const std::string chosen = model_->selected() ? model_->approach(*model_->selected()).name : std::string();
            open(std::move(*saved));
            if (!chosen.empty())
                select(chosen);
            correct_labels();
            show_message("The labels are saved. Plans are made with them from now on.");
        });
    });
}

void MainWindow::draw_incision()
{
    set_measuring(false);
    tabs_->setCurrentWidget(panel_); // the mouse is the knife's no more
    set_knife(KnifeMode::away);
    editor_->draw();
    show_all();
}

void MainWindow::move_incision()
{
    set_measuring(false);
    tabs_->setCurrentWidget(panel_);
    set_knife(KnifeMode::away);
    editor_->move_points();
    show_all();
}

void MainWindow::make_start_page()
{
    start_page_ = new StartPage;
    pages_->addWidget(start_page_);
    start_page_->on_import = [this] { import_study(); };
    start_page_->on_open = [this] { ask_for_case(); };
    start_page_->on_demo_patient = [this] { open_demo_patient(free_case_folder("demo-patient")); };
    start_page_->on_tour = [this] { begin_tour(); };
    start_page_->on_trainer = [this] { open_trainer(); };
    start_page_->on_cancel = [this] { reading_executor_.cancel(); };
    start_page_->on_recent = [this](const std::filesystem::path& file) { open_file(file); };
}

bool MainWindow::start_page_shown() const { return pages_->currentWidget() == start_page_; }

void MainWindow::show_start_page()
{
    pages_->setCurrentIndex(model_ == nullptr ? 1 : 0);
    if (start_work_.isEmpty())
        start_page_->show_work(reading_ > 0 ? "Reading the case" : "", std::nullopt);
    else
        start_page_->show_work(start_work_, reading_executor_.progress().fraction);
}

void MainWindow::remember_cases()
{
    remembers_ = true;
    start_page_->show_recent(recent_cases());
}

void MainWindow::import_study(const std::filesystem::path& study)
{
    auto* dialog = new ImportDialog(this);
    dialog->setAttribute(Qt::WA_DeleteOnClose);
    dialog->on_imported = [this](const std::filesystem::path& case_file) { open_file(case_file); };
    dialog->open();
    if (!study.empty())
        dialog->set_study(study);
}

/// Runs work that the start page waits for. What `task` returns runs in the window's thread.
void MainWindow::run_start_work(const QString& what, std::function<std::function<void()>(const Job&)> task)
{
    ++reading_;
    start_work_ = what;
    progress_timer_.start();
    show_all();
    reading_executor_.post([this, task = std::move(task)](const Job& job) {
        std::function<void()> deliver;
        try {
            deliver = task(job);
        } catch (...) {
            deliver = [this, failure = with_controls(current_failure())] { show_error(failure); };
        }
        post_back([this, deliver] {
            --reading_;
            start_work_.clear();
            show_all();
            deliver();
        });
    });
}

void MainWindow::open_demo_patient(const std::filesystem::path& folder)
{
    run_start_work("Making the demo patient", [this, folder](const Job& job) -> std::function<void()> {
        std::error_code code;
        const bool is_new = !std::filesystem::exists(folder, code);
        const auto remove_part = [&] { // nothing of others is in a new folder
            if (is_new)
                std::filesystem::remove_all(folder, code);
        };
        try {
            if (planner::write_demo_patient(folder, job))
                return [this, folder] { open_file(folder / planner::kCaseFileName); };
        } catch (...) {
            remove_part();
            throw;
        }
        remove_part();
        return [this] { tour_case_.clear(); };
    });
}

void MainWindow::open_trainer()
{
    run_start_work("Making the aorta", [this](const Job&) -> std::function<void()> {
        auto made = std::make_shared<planner::Palpable>(
            planner::Palpable { datasets::make_aorta_phantom(datasets::AortaParameters {}), {} });
        return [this, made] {
            if (on_palpable)
                on_palpable(std::move(*made));
        };
    });
}

void MainWindow::make_knife()
{
    knife_ = std::make_unique<KnifeTool>(*view_, *knife_panel_);
    knife_->on_change = [this] { show_all(); };
    knife_->on_answer = [this](const std::string& text, bool refused) {
        if (refused)
            show_error({ text, {} });
        else if (text.empty())
            clear_error();
        else
            show_message(QString::fromStdString(text));
    };
    knife_panel_->on_export = [this] { ask_for_export_file(); };
    knife_panel_->on_plan_retractor = [this](const planner::RetractorState& cranked, const Vec3& at) {
        editor_->add_with_retractor(cranked.kind, cranked.opening_mm, at);
    };
    connect(tabs_, &QTabWidget::currentChanged, this, [this] {
        labels_->set_active(false);
        show_corrected_labels();
        if (knife_tab_open() || labels_tab_open()) {
            set_measuring(false);
            editor_->abandon();
        }
        if (!knife_tab_open())
            knife_->set_mode(KnifeMode::away);
        if (labels_tab_open() && model_) {
            if (model_->view_available(ViewPreset::slices))
                model_->set_view(ViewPreset::slices);
            show_all();
            labels_->set_active(true);
        }
        show_all();
        if (slices_shown())
            show_slices();
    });
}

bool MainWindow::knife_tab_open() const { return tabs_->currentWidget() == knife_panel_; }

void MainWindow::set_knife(KnifeMode mode)
{
    if (!model_ || !model_->selected() || only_looks())
        mode = KnifeMode::away;
    if (mode != KnifeMode::away) { // the mouse is the knife's
        labels_->set_active(false); // before the knife takes it
        set_measuring(false);
        editor_->abandon();
    }
    knife_->set_mode(mode);
    if (mode != KnifeMode::away)
        tabs_->setCurrentWidget(knife_panel_);
    show_all();
}

void MainWindow::show_cuts_not_saved()
{
    const std::string reason = knife_->cuts_not_saved();
    const std::string said = "Cuts by hand cannot be saved now, and are lost when the window is closed. " + reason;
    cuts_banner_->say(reason.empty() ? QString() : QString::fromStdString(said), "Try again");
}

void MainWindow::show_knife()
{
    // The banner moves the picture, and with it the line that is being drawn.
    if (knife_->snapshot() == nullptr || !knife_->snapshot()->stroke_open)
        show_cuts_not_saved();
    if (model_ && model_->selected() && knife_tab_open() && !only_looks()) {
        const std::size_t index = *model_->selected();
        knife_->set_up(
            model_->id(index), [make = backend_.surgery_input, approach = model_->approach(index)](const Job& job) {
                return make(approach, job);
            });
        if (const auto& field = model_->state(index).field; field != nullptr)
            knife_->set_planned_force(model_->id(index), planned_force(field->metrics));
    } else {
        knife_->leave();
    }
    knife_action_->setEnabled(model_ && model_->selected() && !only_looks());
    line_action_->setEnabled(knife_action_->isEnabled());
    knife_action_->setChecked(knife_->mode() == KnifeMode::freehand);
    hook_action_->setEnabled(knife_action_->isEnabled());
    hook_action_->setChecked(knife_->mode() == KnifeMode::hooks);
    line_action_->setChecked(knife_->mode() == KnifeMode::line);
    take_out_action_->setEnabled(knife_action_->isEnabled());
    take_out_action_->setChecked(knife_->mode() == KnifeMode::take_out);
}

/// What undo and redo do depends on what the mouse does: a point of an incision, a cut by hand, or an approach.
void MainWindow::show_undo()
{
    const auto name = [](QAction& action, const QString& verb, const std::optional<std::string>& what) {
        action.setText(translated(what ? verb + ": " + QString::fromStdString(*what) : verb));
        action.setIconText(translated(verb)); // all tools fit into 1280 px
        action.setEnabled(what.has_value());
    };
    std::optional<std::string> to_undo, to_redo;
    if (labels_->active()) {
        if (labels_->session() != nullptr) {
            to_undo = labels_->session()->to_undo();
            to_redo = labels_->session()->to_redo();
        }
    } else if (editor_->drawing()) {
        if (editor_->tool().can_undo())
            to_undo = "the last change of the points";
    } else if (measuring_) {
        if (model_->has_measurements())
            to_undo = "the last place";
    } else if (const planner::SurgerySnapshot* snapshot = knife_->snapshot(); snapshot != nullptr) {
        if (!snapshot->to_undo.empty())
            to_undo = snapshot->to_undo;
        if (!snapshot->to_redo.empty())
            to_redo = snapshot->to_redo;
    } else if (model_) {
        to_undo = model_->edit_to_undo();
        to_redo = model_->edit_to_redo();
    }
    name(*undo_, "Undo", to_undo);
    name(*redo_, "Redo", to_redo);
}

void MainWindow::undo()
{
    if (labels_->active()) {
        labels_->undo();
        show_undo();
    } else if (editor_->drawing()) {
        editor_->undo_point();
        show_undo();
    } else if (measuring_) {
        model_->unmeasure();
        show_measurements();
    } else if (knife_->snapshot() != nullptr) {
        knife_->run(planner::surgery::Undo {});
    } else if (model_ && model_->edit_to_undo()) {
        const QString what = QString::fromStdString(*model_->edit_to_undo());
        model_->undo_edit();
        editor_->on_edit();
        show_message("Taken back: " + what);
    }
}

void MainWindow::redo()
{
    if (labels_->active()) {
        labels_->redo();
        show_undo();
    } else if (knife_->snapshot() != nullptr) {
        knife_->run(planner::surgery::Redo {});
    } else if (model_ && model_->edit_to_redo() && !editor_->drawing()) {
        const QString what = QString::fromStdString(*model_->edit_to_redo());
        model_->redo_edit();
        editor_->on_edit();
        show_message("Made again: " + what);
    }
}

void MainWindow::make_status_line()
{
    message_ = add_message(*statusBar());
    progress_ = new QProgressBar;
    progress_->setRange(0, kProgressSteps);
    progress_->setFixedWidth(300);
    cancel_button_ = new QPushButton("Cancel");
    cancel_button_->setObjectName("cancel");
    connect(cancel_button_, &QPushButton::clicked, this, [this] { cancel_work(); });
    statusBar()->addPermanentWidget(progress_);
    statusBar()->addPermanentWidget(cancel_button_);
    add_notice(*statusBar());
}

void MainWindow::open(planner::Case planned_case)
{
    const auto read_at = time_of(planned_case.file());
    open_as_read(std::move(planned_case), read_at);
}

void MainWindow::open_as_read(planner::Case planned_case, std::optional<std::filesystem::file_time_type> read_at)
{
    set_conference(false);
    end_tour();
    set_measuring(false);
    editor_->abandon();
    knife_->abandon();
    cancel_planning();
    cancel_palpation();
    knife_->clear();
    ++generation_;
    closed_running_ = 0;
    plans_running_ = 0;
    const ViewPreset before = model_ ? model_->view() : ViewPreset::surgeon;
    const ViewPreset view = before == ViewPreset::compare ? ViewPreset::surgeon : before;
    backend_ = factory_(planned_case);
    const std::size_t grey_window = model_ ? model_->grey_window() : 0;
    const LabelLook label_look = model_ ? model_->label_look() : LabelLook::filled;
    const WallLook wall_look = model_ ? model_->wall_look() : WallLook::solid;
    close_case_dialogs();
    editor_->set_case(nullptr, {});
    const bool is_same = model_ && model_->planned_case().file() == planned_case.file();
    const planner::Weights weights = is_same ? model_->weights() : planner::default_weights();
    model_ = std::make_unique<SessionModel>(std::move(planned_case));
    if (!is_same || only_looks())
        lock_case();
    editor_->set_case(model_.get(), backend_);
    labels_->set_case(model_->planned_case(), backend_.labels);
    read_decisions();
    saving_executor_.post([this, read_at](const Job&) { case_time_ = read_at; });
    show_not_saved({}, false);
    if (remembers_) {
        remember_case(model_->planned_case().file());
        pictured_.clear();
    }
    model_->set_view(view);
    model_->set_grey_window(grey_window);
    model_->set_label_look(label_look);
    model_->set_wall_look(wall_look);
    model_->set_weights(weights);
    const planner::Case& shown = model_->planned_case();
    const std::filesystem::path name = shown.file_name == planner::kCaseFileName
        ? shown.folder.filename()
        : shown.folder.filename() / shown.file_name;
    setWindowTitle("Retractor - " + QString::fromStdString(name.string()));
    log_.hide(shown.file());
    clear_error();
    hand_out_work();
    make_anatomy(); // after the first picture
    show_all();
    if (labels_tab_open())
        tabs_->setCurrentWidget(panel_); // the mouse turns the picture of the new case
    if (!tour_case_.empty() && shown.file() == tour_case_) {
        tour_case_.clear();
        return begin_tour();
    }
    if (!only_looks())
        labels_->mention_unsaved();
}

bool MainWindow::only_looks() const { return lock_ && !lock_->is_mine(); }

/// Takes the open case for this window, or says which window has it.
void MainWindow::lock_case()
{
    lock_.reset(); // before another is taken: it may be of the same case
    const std::filesystem::path file = model_->planned_case().file();
    if (!file.empty())
        lock_ = std::make_unique<CaseLock>(file);
    if (!only_looks())
        return looking_banner_->say({});
    const std::string lock_name = CaseLock::file_of(file).filename().string();
    looking_banner_->say(
        QString::fromStdString("Another window " + lock_->holder()
            + " has this case open. Here you can look at it and plan it, but not change it. Close the other window, "
              "then look again. If its computer has failed, delete the file "
            + lock_name + " beside the case."),
        "Look again");
}

void MainWindow::close_case()
{
    if (!model_ || !may_leave_case("Close the case?"))
        return;
    set_conference(false);
    end_tour();
    set_measuring(false);
    editor_->abandon();
    knife_->abandon();
    cancel_planning();
    cancel_palpation();
    knife_->clear();
    close_case_dialogs();
    editor_->set_case(nullptr, {});
    labels_->set_case({}, {});
    ++generation_;
    closed_running_ = 0;
    plans_running_ = 0;
    model_.reset();
    backend_ = {};
    shown_ = {};
    view_->show_scenes({});
    show_not_saved({}, false);
    lock_.reset();
    looking_banner_->say({});
    setWindowTitle("Retractor");
    clear_error();
    if (remembers_)
        start_page_->show_recent(recent_cases());
    show_all();
}

/// Writes the case with its present approaches.
void MainWindow::save_case(bool over_others)
{
    ++saving_;
    saving_executor_.post(
        [this, over_others, generation = generation_, planned_case = model_->planned_case()](const Job&) {
            std::string reason;
            bool changed = false;
            try {
                const auto now = time_of(planned_case.file());
                changed = !over_others && case_time_ && now && *now != *case_time_;
                if (changed)
                    throw IoError("Another program has changed the case meanwhile.", planned_case.file().string());
                planner::write_case(planned_case);
                case_time_ = time_of(planned_case.file());
            } catch (...) {
                reason = to_string(current_failure());
            }
            post_back([this, generation, reason, changed] {
                --saving_;
                if (generation == generation_)
                    show_not_saved(reason, changed);
                else if (!reason.empty())
                    show_error({ "the approaches of the case that was closed are not saved: " + reason });
            });
        });
}

void MainWindow::show_not_saved(const std::string& reason, bool changed_by_others)
{
    not_saved_ = reason;
    changed_by_others_ = changed_by_others;
    not_saved_banner_->say(reason.empty()
            ? QString()
            : QString::fromStdString("The approaches are not saved, and are lost when the window is closed. " + reason),
        changed_by_others ? "Overwrite it" : "Try again");
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
    if (!may_leave_case("Open another case?"))
        return;
    log_.hide(path);
    ++reading_;
    view_->show_note("Reading " + QString::fromStdString(path.string()) + " …");
    show_start_page();
    reading_executor_.post([this, path](const Job&) {
        std::error_code code;
        const auto read_at = time_of(std::filesystem::is_directory(path, code) ? path / planner::kCaseFileName : path);
        try {
            auto planned_case = std::make_shared<planner::Case>(planner::read_case(path));
            post_back([this, planned_case, read_at] {
                --reading_;
                open_as_read(std::move(*planned_case), read_at);
            });
        } catch (const Error& error) {
            reading_failed(case_failure(path, error));
        } catch (...) {
            reading_failed(with_controls(current_failure()));
        }
    });
}

/// Makes a palpable tissue beside the case. What `task` returns runs in the window's thread, unless one cancels.
void MainWindow::prepare_palpation(const QString& message, std::function<std::function<void()>(const Job&)> task)
{
    ++reading_;
    ++palpations_prepared_;
    show_message(message);
    show_all();
    reading_executor_.post([this, task = std::move(task), generation = generation_](const Job& job) {
        std::function<void()> deliver;
        try {
            deliver = task(job);
        } catch (...) {
            deliver = [this, failure = with_controls(current_failure())] { show_error(failure); };
        }
        if (job.cancelled())
            deliver = [this] { show_message("The palpation was cancelled."); };
        post_back([this, deliver, generation] {
            --reading_;
            --palpations_prepared_;
            if (generation == generation_)
                clear_error();
            show_all();
            if (generation == generation_) // else its case is closed
                deliver();
        });
    });
}

void MainWindow::palpate(const std::string& structure)
{
    prepare_palpation(QString("Preparing %1 for palpation …").arg(QString::fromStdString(structure)),
        [this, structure, patient_case = model_->planned_case()](const Job& job) -> std::function<void()> {
            planner::Patient patient(patient_case);
            planner::PalpableRequest request;
            request.structure = { structure };
            auto made = std::make_shared<planner::Palpable>(planner::make_palpable(patient, request, job));
            return [this, made] {
                if (on_palpable)
                    on_palpable(std::move(*made));
            };
        });
}

void MainWindow::palpate_through_wound()
{
    if (!palpate_through_->isEnabled())
        return;
    prepare_palpation("Preparing the target for palpation through the wound …",
        [this, make = backend_.palpate_through, approach = model_->approach(*model_->selected())](
            const Job& job) -> std::function<void()> {
            auto made = std::make_shared<ShownWound>(make(approach, job));
            return [this, made] {
                if (on_palpable_wound)
                    on_palpable_wound(std::move(*made));
            };
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
    if (!model_ || !model_->view_available(view) || (editor_->drawing() && !is_drawn_on(view)))
        return;
    if (labels_->active() && view != ViewPreset::slices)
        tabs_->setCurrentWidget(panel_); // the mouse is the brush's no more
    if (knife_tab_open() && !is_drawn_on(view))
        tabs_->setCurrentWidget(panel_); // the wound by hand is seen in space only
    const bool again = view == model_->view();
    model_->set_view(view);
    show_all();
    if (optics_deg_ >= 0.0 || (again && knife_->scene() != nullptr))
        reset_view(); // the same picture, but not through the endoscope, or from where the hand turned it
}

void MainWindow::plan_selected(bool as_draft)
{
    if (!model_ || !model_->selected())
        return;
    clear_error();
    tabs_->setCurrentWidget(panel_);
    model_->set_show_opened(true);
    model_->request_plan(*model_->selected(), as_draft);
    hand_out_work();
    show_all();
    say_labels_not_saved();
}

void MainWindow::plan_all()
{
    if (!model_)
        return;
    clear_error();
    tabs_->setCurrentWidget(panel_);
    model_->set_show_opened(true);
    for (std::size_t index = 0; index < model_->approach_count(); ++index)
        model_->request_plan(index);
    hand_out_work();
    show_all();
    say_labels_not_saved();
}

void MainWindow::say_labels_not_saved()
{
    if (labels_->changed())
        show_message("The plan uses the labels as saved: the corrections are not saved yet.");
}

void MainWindow::cancel()
{
    if (in_conference())
        return set_conference(false);
    if (measuring_)
        return set_measuring(false);
    if (in_tour() && !editor_->drawing() && knife_->mode() == KnifeMode::away && !labels_->active())
        return end_tour();
    if (labels_->active())
        return tabs_->setCurrentWidget(panel_);
    if (!editor_->abandon() && !knife_->abandon())
        cancel_work();
}

void MainWindow::cancel_palpation()
{
    if (palpations_prepared_ > 0)
        reading_executor_.cancel();
}

void MainWindow::cancel_planning()
{
    if (!model_)
        return;
    model_->cancel();
    planning_executor_.cancel();
    show_all();
}

void MainWindow::cancel_work()
{
    if (model_ && model_->busy())
        return cancel_planning();
    cancel_palpation();
    export_executor_.cancel();
    show_all();
}

bool MainWindow::idle() const
{
    return reading_ == 0 && saving_ == 0 && closed_running_ == 0 && plans_running_ == 0 && exports_running_ == 0
        && knife_->idle() && editor_->idle() && labels_->idle()
        && (search_dialog_ == nullptr || search_dialog()->idle());
}

void MainWindow::hand_out_work()
{
    if (model_->planning_unwanted())
        planning_executor_.cancel();
    if (const auto index = backend_.saved_plan ? model_->begin_saved() : std::nullopt)
        read_saved_plan(*index);
    if (const auto work = model_->begin_closed())
        make_closed(*work);
    if (const auto index = model_->begin_plan())
        make_plan(*index);
}

void MainWindow::make_closed(const ClosedWork& work)
{
    ++closed_running_;
    closed_executor_.post([this, generation = generation_, backend = backend_, approach = work.approach](const Job&) {
        std::function<void()> deliver;
        try {
            auto pictures = std::make_shared<ClosedPictures>(
                approach ? backend.closed_pictures(*approach, Job {}) : backend.patient_pictures(Job {}));
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

void MainWindow::read_saved_plan(std::size_t index)
{
    ++closed_running_;
    closed_executor_.post(
        [this, generation = generation_, backend = backend_, approach = model_->approach(index)](const Job&) {
            auto found = std::make_shared<std::optional<FieldPictures>>();
            std::optional<Failure> failure;
            try {
                *found = backend.saved_plan(approach);
            } catch (...) {
                failure = with_controls(current_failure());
            }
            post_back(generation, [this, found, failure] {
                --closed_running_;
                model_->saved_done(std::move(*found));
                if (failure)
                    show_error(*failure);
                hand_out_work();
                show_all();
            });
        });
}

void MainWindow::make_plan(std::size_t index)
{
    ++plans_running_;
    planning_executor_.post(
        [this, generation = generation_, plan = model_->state(index).as_draft ? backend_.draft : backend_.plan,
            approach = model_->approach(index)](const Job& job) {
            std::function<void()> deliver;
            try {
                job.report("begin", 0.0);
                auto outcome = std::make_shared<PlanOutcome>(plan(approach, job));
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
    renew_steps();
    show_start_page();
    if (model_)
        list_->show_model(*model_);
    else
        list_->clear();
    panel_->show_model(model_.get());
    show_knife();
    show_actions();
    show_undo();
    show_progress();
    show_picture();
}

void MainWindow::show_actions()
{
    const bool any = model_ && model_->selected();
    const ApproachState* state = any ? &model_->state(*model_->selected()) : nullptr;
    for (const auto& [action, view] : { std::pair { surgeon_, ViewPreset::surgeon },
             std::pair { overview_, ViewPreset::overview }, std::pair { slices_, ViewPreset::slices },
             std::pair { incision_, ViewPreset::incision }, std::pair { compare_, ViewPreset::compare } }) {
        action->setEnabled(model_ && model_->view_available(view) && !(editor_->drawing() && !is_drawn_on(view)));
        action->setChecked(model_ && model_->shown_view() == view);
    }
    grey_windows_->setEnabled(slices_->isEnabled());
    label_looks_->setEnabled(slices_->isEnabled());
    label_looks_->actions().at(model_ ? static_cast<int>(model_->label_look()) : 0)->setChecked(true);
    for (QAction* action : maps_->actions()) {
        const int map = action->data().toInt();
        action->setEnabled(model_ && (map < 0 || model_->map_available(static_cast<FieldMapKind>(map))));
        action->setChecked(map == (model_ && model_->map() ? static_cast<int>(*model_->map()) : -1));
    }
    confer_->setEnabled(model_ != nullptr);
    confer_->setChecked(in_conference());
    notes_action_->setEnabled(in_conference());
    notes_action_->setChecked(notes_->isVisible());
    grey_windows_->actions().at(static_cast<int>(model_ ? model_->grey_window() : 0))->setChecked(true);
    const bool compares = model_ && model_->shown_view() == ViewPreset::compare;
    wall_looks_->setEnabled(model_ != nullptr);
    wall_looks_->actions().at(model_ ? static_cast<int>(model_->wall_look()) : 0)->setChecked(true);
    cut_sides_->setEnabled(model_ && model_->can_cut_away());
    for (QAction* action : cut_sides_->actions())
        action->setChecked(
            action->data().toInt() == (model_ && model_->cut_side() ? static_cast<int>(*model_->cut_side()) : -1));
    linked_->setEnabled(compares);
    keep_view_->setEnabled(any && is_drawn_on(model_->shown_view()) && shown_.pictures != nullptr
        && !model_->planned_case().file().empty() && knife_->scene() == nullptr);
    forget_view_->setEnabled(model_ && !model_->decisions().views.empty());
    reset_view_->setEnabled(model_ && shown_.pictures != nullptr);
    opened_->setEnabled(any && state->field != nullptr && !editor_->drawing() && !compares);
    opened_->setChecked(opened_->isEnabled() && model_->show_opened());
    plan_->setEnabled(any && model_->can_plan(*model_->selected()));
    draft_->setEnabled(any && backend_.draft && model_->can_plan(*model_->selected(), true));
    plan_all_->setEnabled(any);
    save_->setEnabled(model_ != nullptr);
    movie_->setEnabled(any && backend_.write_movie && exports_running_ == 0);
    report_->setEnabled(model_ && !model_->planned().empty() && backend_.write_report && exports_running_ == 0);
    close_case_->setEnabled(model_ != nullptr);
    palpate_->setEnabled(model_ != nullptr && static_cast<bool>(on_palpable));
    palpate_through_->setEnabled(any && state->field != nullptr && !state->as_draft && backend_.palpate_through
        && static_cast<bool>(on_palpable_wound));
    new_approach_->setEnabled(model_ != nullptr);
    search_->setEnabled(model_ != nullptr && backend_.search != nullptr);
    weights_->setEnabled(model_ != nullptr);
    measure_->setEnabled(model_ && shown_.pictures != nullptr && !knife_tab_open() && !labels_tab_open()
        && !editor_->drawing() && !compares);
    correct_->setEnabled(model_ && model_->view_available(ViewPreset::slices));
    measure_area_->setEnabled(measure_->isEnabled());
    forget_measurements_->setEnabled(model_ && model_->has_measurements());
    measure_->setChecked(measuring_ && !measuring_area_);
    measure_area_->setChecked(measuring_area_);
    straight_optics_->setEnabled(any && state->field != nullptr && !editor_->drawing() && knife_->scene() == nullptr);
    oblique_optics_->setEnabled(straight_optics_->isEnabled());
    large_->setEnabled(model_ && model_->view_available(ViewPreset::slices));
    draw_->setEnabled(editor_->draw_possible());
    draw_->setChecked(editor_->drawing() && !editor_->moving());
    move_->setEnabled(editor_->draw_possible() && any);
    move_->setChecked(editor_->moving());
    finish_->setEnabled(editor_->drawing() || measuring_area_);
    questions_->setEnabled(any);
    for (QAction* action : { change_, duplicate_, neighbours_, remove_, choose_ })
        action->setEnabled(any && !editor_->drawing());
    site_->setEnabled(any && model_->slice_place().has_value() && !editor_->drawing()
        && (model_->view() == ViewPreset::slices || model_->shown_state().slice_point));
    if (only_looks())
        for (QAction* action : { new_approach_, search_, draw_, move_, change_, site_, duplicate_, neighbours_, remove_,
                 choose_, questions_, correct_, keep_view_, forget_view_ })
            action->setEnabled(false);
    for (QWidget* tab : { static_cast<QWidget*>(knife_panel_), static_cast<QWidget*>(label_panel_) })
        tabs_->setTabEnabled(tabs_->indexOf(tab), !only_looks());
}

void MainWindow::show_picture()
{
    if (!model_) {
        view_->show_note({});
        return;
    }
    const std::shared_ptr<const Scene> by_hand = knife_->scene();
    ShownSource source = model_->shown_source();
    if (by_hand != nullptr)
        source = { .pictures = by_hand,
            .opened = false,
            .view = model_->view(),
            .approach = model_->selected(),
            .name = source.name };
    view_->show_note(
        source.pictures == nullptr && closed_running_ > 0 ? "Reading the patient …" : knife_->waiting_for());
    if (source == shown_)
        return;
    try {
        std::vector<Scene> scenes
            = by_hand != nullptr ? std::vector<Scene> { knife_scene(*by_hand, source) } : model_->shown_scenes();
        shown_ = std::move(source);
        show_linked();
        const bool large = large_->isChecked() && shows_slices(shown_.view);
        view_->set_layout(large ? SceneLayout::one_large : SceneLayout::grid);
        view_->show_scenes(std::move(scenes));
        if (std::exchange(optics_deg_, -1.0) >= 0.0)
            clear_error(); // what was said of the endoscope
        view_->set_handle(blade_handle());
        show_camera_of_step();
    } catch (...) {
        show_error(with_controls(current_failure()));
    }
    if (const std::string errors = view_->drawing_errors(); !errors.empty())
        show_error({ errors, "drawing" });
}

void MainWindow::set_map(std::optional<FieldMapKind> map)
{
    model_->set_map(map);
    if (map) {
        model_->set_show_opened(true);
        if (!is_drawn_on(model_->shown_view()) && model_->shown_view() != ViewPreset::compare)
            model_->set_view(ViewPreset::surgeon);
        if (*map == FieldMapKind::eyes) // drawn from outside
            model_->set_view(ViewPreset::overview);
    }
    show_all();
}

void MainWindow::show_linked()
{
    view_->set_linked(linked_->isChecked() && model_ && model_->shown_view() == ViewPreset::compare);
}

void MainWindow::reset_view()
{
    shown_ = {};
    show_picture();
}

void MainWindow::move_slices(const Vec3& point)
{
    if (!slices_shown())
        return;
    model_->set_slice_point(point);
    show_place();
}

void MainWindow::finish()
{
    if (!measuring_area_)
        return editor_->finish();
    model_->end_measurement();
    show_measurements();
    show_message("Click the corners of the next area. Esc ends.");
}

void MainWindow::set_measuring(bool on, bool area)
{
    const bool possible = model_ && shown_.pictures != nullptr && knife_->scene() == nullptr && !editor_->drawing();
    if (on && possible) {
        view_->set_tool(measure_tool_.get());
        if (measuring_)
            model_->end_measurement();
        show_measurements();
        show_message(area ? "Click the corners of the area. Enter begins another, Esc ends, Ctrl+Z takes a corner back."
                          : "Click two places for a distance, a third for an angle. Esc ends, Ctrl+Z takes a place "
                            "back.");
    } else if (measuring_) {
        model_->end_measurement();
        view_->set_tool(nullptr);
        show_measurements();
        show_message({});
    }
    measuring_ = on && possible;
    measuring_area_ = measuring_ && area;
    show_all();
}

void MainWindow::forget_measurements()
{
    if (!model_)
        return;
    model_->forget_measurements();
    show_measurements();
}

/// Shows the measurements as they are now, and what can be done with them.
void MainWindow::show_measurements()
{
    show_again([](const Scene&) { return true; });
    show_undo();
    forget_measurements_->setEnabled(model_->has_measurements());
}

void MainWindow::measure_at(const QPointF& at)
{
    std::optional<Vec3> place = view_->slice_place_at(at);
    const bool in_space = view_->scenes().size() == 1 && view_->scenes().front().slices.empty();
    if (in_space && shown_.opened)
        return show_message("Press O first: only the closed skin can be measured.");
    if (!place && in_space && model_->shown_state().closed != nullptr && model_->shown_state().closed->skin_under) {
        const planner::Ray ray = view_->ray_at(at);
        place = model_->shown_state().closed->skin_under(ray.origin, ray.direction);
    }
    if (!place)
        return show_message(in_space ? "Click on the skin." : "Click on a slice.");
    const std::string text = measuring_area_ ? model_->measure_area(*place) : model_->measure(*place);
    show_measurements();
    show_message(!text.empty() ? QString::fromStdString(text)
            : measuring_area_  ? QString("Click the next corner.")
                               : QString("Click the second place."));
}

void MainWindow::set_grey_window(std::size_t index)
{
    if (!model_)
        return;
    model_->set_grey_window(index);
    if (slices_shown())
        show_slices();
}

/// Lets one picture of several fill the view, or shows all again.
void MainWindow::enlarge(std::size_t scene)
{
    if (!model_ || (!model_->alone() && view_->scenes().size() < 2))
        return;
    model_->set_alone(model_->alone() ? std::nullopt : std::optional(scene));
    show_all();
}

void MainWindow::set_label_look(LabelLook look)
{
    if (!model_)
        return;
    model_->set_label_look(look);
    if (slices_shown())
        show_slices();
}

void MainWindow::open_manual()
{
    const auto folder = manual_folder(QCoreApplication::applicationDirPath().toStdString());
    if (!folder)
        return show_message("The manual is not installed beside the program. It is also in the source, in docs/user.");
    const QString heading = start_page_shown()        ? "The start page"
        : in_conference()                             ? "In the case conference"
        : labels_tab_open()                           ? "Correcting labels"
        : knife_tab_open()                            ? "Cutting by hand"
        : measuring_                                  ? "Measuring"
        : editor_->drawing()                          ? "Approaches"
        : model_->shown_view() == ViewPreset::compare ? "Comparing"
        : slices_shown()                              ? "Looking inside"
        : model_->shown_source().map                  ? "Numbers as colours"
                                                      : "";
    const QString translated_page = language() + "/getting-started.md"; // the first pages are in other languages too
    std::error_code code;
    if ((heading.isEmpty() || start_page_shown())
        && std::filesystem::exists(*folder / translated_page.toStdString(), code))
        return static_cast<void>(show_manual(*folder, translated_page, {}, this));
    show_manual(*folder, "workstation.md", heading, this);
}

std::string MainWindow::log_text() { return log_.text(view_->renderer()); }

/// Whether the picture is that of the slices, and not that of the knife.
bool MainWindow::slices_shown() const
{
    return model_ && shows_slices(model_->view()) && shown_ == model_->shown_source() && shown_.pictures != nullptr;
}

/// Shows the slices anew, each from where it is seen now.
void MainWindow::show_slices()
{
    show_again([](const Scene& scene) { return !scene.slices.empty(); });
}

/// Shows scenes of the present picture anew, each from where it is seen now. The knife's picture stays.
void MainWindow::show_again(const std::function<bool(const Scene&)>& which)
{
    if (shown_.pictures == nullptr || shown_ != model_->shown_source())
        return;
    try {
        const std::vector<Scene> scenes = model_->shown_scenes();
        for (std::size_t i = 0; i < std::min(scenes.size(), view_->scenes().size()); ++i)
            if (which(scenes[i]) && scenes[i].slices.size() == view_->scenes()[i].slices.size())
                view_->replace_scene(i, scenes[i]);
    } catch (...) {
        show_error(with_controls(current_failure()));
    }
}

/// The scene for the knife. The camera stays in place when only the knife was taken or put away.
Scene MainWindow::knife_scene(const Scene& surroundings, const ShownSource& source) const
{
    Scene scene = surroundings;
    model_->put_present_name(scene);
    scene.lines.clear(); // the tool draws the planned incision until hooks hold the wound open
    const bool in_space = view_->scenes().size() == 1 && view_->scenes().front().slices.empty();
    if (in_space && shown_.pictures != nullptr && shown_.view == source.view && shown_.approach == source.approach)
        scene.camera = view_->camera();
    else if (source.view == ViewPreset::surgeon) {
        const auto& field = model_->shown_state().field;
        const planner::SurgerySnapshot* const wound = knife_->snapshot();
        const bool is_open = wound != nullptr && !wound->hooks.hooks.empty();
        scene.camera = field != nullptr && is_open // the eye that sees most of the target
            ? field->surgeon.camera
            : surgeon_camera(model_->approach(*model_->selected()), scene.camera.up);
    }
    return scene;
}

void MainWindow::show_progress()
{
    const bool plans = model_ && model_->busy(), saves = exports_running_ > 0;
    const bool busy = plans || saves || palpations_prepared_ > 0;
    cancel_->setEnabled(in_tour() || busy || knife_->mode() != KnifeMode::away || editor_->drawing() || measuring_
        || labels_->active() || in_conference());
    progress_->setVisible(busy);
    cancel_button_->setVisible(busy);
    if (reading_ > 0)
        show_start_page();
    if (!busy) {
        if (reading_ == 0)
            progress_timer_.stop();
        return;
    }
    progress_timer_.start();
    if (saves) {
        const SerialExecutor::Progress writing = export_executor_.progress();
        const QString stage = QString::fromStdString(stage_in_words(writing.stage));
        conference_bar_->show_note(translated(writing.fraction > 0.0
                ? QString("Saving: %1 (%2 %)").arg(stage).arg(100.0 * writing.fraction, 0, 'f', 0)
                : QString("Saving: %1 …").arg(stage)));
        if (!plans) {
            cancel_button_->setEnabled(true);
            progress_->setValue(static_cast<int>(kProgressSteps * writing.fraction));
            progress_->setFormat(translated("saving: " + stage_in_words(writing.stage)));
            return;
        }
    }
    if (!plans) {
        const SerialExecutor::Progress preparing = reading_executor_.progress();
        cancel_button_->setEnabled(true);
        progress_->setValue(static_cast<int>(kProgressSteps * preparing.fraction));
        progress_->setFormat(translated(stage_in_words(preparing.stage)));
        return;
    }
    const bool cancelling = model_->planning_unwanted();
    cancel_button_->setEnabled(!cancelling);
    const SerialExecutor::Progress planning = planning_executor_.progress();
    progress_->setValue(static_cast<int>(kProgressSteps * planning.fraction));
    progress_->setFormat(translated(cancelling ? std::string("cancelling") : stage_in_words(planning.stage)));
}

void MainWindow::show_error(const Failure& failure)
{
    error_ = to_string(failure);
    tour_case_.clear(); // its patient may be what failed
    log_.add("error", error_);
    message_->setStyleSheet("color: #ff8a80;");
    message_->setText(translated(error_));
    message_->setToolTip(message_->text());
    start_page_->show_failure(message_->text());
    conference_bar_->show_note(message_->text());
}

void MainWindow::show_message(const QString& text)
{
    clear_error();
    log_.add("message", text.toStdString());
    message_->setStyleSheet({});
    message_->setText(translated(text));
    message_->setToolTip(message_->text()); // two lines may not hold it
    conference_bar_->show_note(message_->text());
}

std::string MainWindow::message_line() const { return message_->text().toStdString(); }

void MainWindow::clear_error()
{
    error_.clear();
    message_->clear();
    message_->setToolTip({});
    start_page_->show_failure({});
    conference_bar_->show_note({});
}

void MainWindow::ask_for_case()
{
    const QString file
        = QFileDialog::getOpenFileName(this, translated("Open case"), {}, translated("Case (case.json *.json)"));
    if (!file.isEmpty())
        open_file(file.toStdString());
}

void MainWindow::ask_for_structure()
{
    if (!model_)
        return;
    const mesh::LabelTable table = model_->planned_case().label_table; // as it is while the dialog waits
    QStringList names;
    int vessel = 0;
    for (const mesh::LabelInfo& info : table) {
        if (info.material == "vessel" && vessel == 0)
            vessel = static_cast<int>(names.size());
        names += translated(readable(info.name));
    }
    bool chosen = false;
    const QString name = QInputDialog::getItem(this, translated("Palpate"),
        translated("Structure to palpate (a vessel gets a wall of 2 mm, filled with blood):"), names, vessel, false,
        &chosen);
    if (const auto at = names.indexOf(name); chosen && at >= 0)
        palpate(table[static_cast<std::size_t>(at)].name);
}

void MainWindow::show_about()
{
    QMessageBox::about(this, translated("About Retractor"),
        "<h3>Retractor " RETRACTOR_VERSION "</h3>"
        "<p>A surgical incision planning workstation: draw the incision, open it with hooks, see what the surgeon will "
        "see.</p>"
        "<p><b>Not a medical device.</b> The pictures and numbers come from a model with assumed tissue properties. "
        "They are for "
        "research and teaching and must not be used to treat a patient.</p>"
        "<p>Free software under the GPL, version 3 or later.</p>");
}

} // namespace retractor::ui
