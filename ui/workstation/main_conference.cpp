// The conference of the main window: full screen, large type, the plans step by step; and what the team decides.

#include "planner/approach/approach_draft.h"
#include "planner/measures/provenance.h"
#include "planner/measures/verdict.h"
#include "ui/plan_scene/plan_scene.h"
#include "ui/plan_scene/planned_cut.h"
#include "ui/workstation/conference/decision_dialogs.h"
#include "ui/workstation/conference/notes_window.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/view/picture_view.h"
#include "ui/workstation/view/step_bar.h"

#include <QActionGroup>
#include <QFileDialog>
#include <QInputDialog>
#include <QMenuBar>
#include <QPainter>
#include <QStatusBar>
#include <QTabWidget>
#include <QToolBar>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <utility>

namespace retractor::ui {

namespace {

    /// A red disc that everybody in the room sees.
    QCursor pointer()
    {
        constexpr int kAcrossPx = 18;
        QPixmap picture(kAcrossPx, kAcrossPx);
        picture.fill(Qt::transparent);
        QPainter painter(&picture);
        painter.setRenderHint(QPainter::Antialiasing);
        painter.setPen(QPen(Qt::white, 1.0));
        painter.setBrush(QColor(255, 40, 40));
        painter.drawEllipse(1, 1, kAcrossPx - 2, kAcrossPx - 2);
        painter.end();
        return QCursor(picture, kAcrossPx / 2, kAcrossPx / 2);
    }

    ViewPreset preset_of(planner::PresentedView view)
    {
        switch (view) {
        case planner::PresentedView::blade:
            return ViewPreset::incision;
        case planner::PresentedView::seen:
        case planner::PresentedView::reached:
            return ViewPreset::surgeon;
        case planner::PresentedView::comparison:
            return ViewPreset::compare;
        case planner::PresentedView::patient:
        case planner::PresentedView::incision:
        case planner::PresentedView::cut:
        case planner::PresentedView::opened:
        case planner::PresentedView::kept:
            break;
        }
        return ViewPreset::overview;
    }

    bool shows_opened(const planner::PresentationStep& step)
    {
        const planner::PresentedView view = step.view;
        if (step.kept)
            return step.kept->opened;
        return view == planner::PresentedView::opened || view == planner::PresentedView::seen
            || view == planner::PresentedView::reached || view == planner::PresentedView::comparison;
    }

    /// Whether the picture of a step is seen from another place than outside the conference.
    bool has_own_camera(const planner::PresentationStep& step)
    {
        return step.kept || step.view == planner::PresentedView::cut;
    }

} // namespace

void MainWindow::make_conference()
{
    conference_bar_->on_step = [this](int steps) { step_by(steps); };
    conference_bar_->on_end = [this] { set_conference(false); };
    conference_bar_->on_movie = [this] { ask_for_movie_file(); };
    conference_bar_->on_report = [this] { ask_for_report_file(); };
    presenter_keys_ = new QActionGroup(this);
    const auto add_keys = [this](const QList<QKeySequence>& keys, std::function<void()> run) {
        auto* action = new QAction(this);
        action->setShortcuts(keys);
        connect(action, &QAction::triggered, this, [run = std::move(run)] { run(); });
        presenter_keys_->addAction(action);
        addAction(action);
    };
    // Presenters for slides send these keys.
    add_keys({ Qt::Key_Right, Qt::Key_PageDown, Qt::Key_Space }, [this] { step_by(1); });
    add_keys({ Qt::Key_Left, Qt::Key_PageUp, Qt::Key_Backspace }, [this] { step_by(-1); });
    add_keys({ Qt::Key_Home }, [this] { go_to_step(0); });
    add_keys({ Qt::Key_End }, [this] { go_to_step(steps_.size() - 1); });
    presenter_keys_->setEnabled(false);
    notes_ = new NotesWindow(this);
    notes_->on_step = [this](int steps) { step_by(steps); };
    notes_->on_end = [this] { set_conference(false); };
    notes_->on_close = [this] { show_actions(); };
    notes_->on_note = [this](const QString& step, const QString& text) {
        if (model_ && !only_looks())
            change_decisions([step = step.toStdString(), text = text.toStdString()](
                                 planner::Decisions& decisions) { planner::set_note(decisions, step, text); },
                QString("")); // the audience reads the messages
    };
}

void MainWindow::show_notes(bool shown)
{
    if (!shown || !in_conference())
        return static_cast<void>(notes_->close());
    notes_->open(!only_looks());
    show_step_in_notes();
}

void MainWindow::show_step_in_notes()
{
    if (!notes_->isVisible() || !in_conference())
        return;
    const planner::PresentationStep& step = steps_[step_];
    notes_->show_step(QString::fromStdString(step.title), QString::fromStdString(step.text),
        step_ + 1 < steps_.size() ? QString::fromStdString(steps_[step_ + 1].title) : QString(),
        QString::fromStdString(planner::note_of(model_->decisions(), step.title)));
}

void MainWindow::show_frame(bool shown)
{
    menuBar()->setVisible(shown);
    tool_bar_->setVisible(shown);
    statusBar()->setVisible(shown);
    approach_pane_->setVisible(shown);
    tabs_->setVisible(shown);
    conference_bar_->setVisible(!shown);
}

void MainWindow::set_conference(bool on)
{
    if (on == in_conference() || (on && !model_))
        return;
    if (on) {
        end_tour();
        if (weights_dialog_ != nullptr)
            weights_dialog_->close();
        set_measuring(false);
        editor_->abandon();
        tabs_->setCurrentIndex(0);
        set_knife(KnifeMode::away);
        notes_->start_clock();
        steps_ = steps_now();
        step_ = 0;
        map_before_conference_ = model_->map();
        wall_before_conference_ = model_->wall_look();
        view_before_conference_ = model_->view();
        opened_before_conference_ = model_->show_opened();
        was_maximized_ = isMaximized();
        showFullScreen();
        view_->setCursor(pointer());
    } else {
        notes_->close();
        model_->set_map(map_before_conference_);
        show_wall_as(wall_before_conference_);
        model_->set_view(view_before_conference_);
        model_->set_show_opened(opened_before_conference_);
        if (has_own_camera(steps_[step_]))
            shown_ = {};
        steps_.clear();
        was_maximized_ ? showMaximized() : showNormal();
        view_->unsetCursor();
    }
    show_frame(!on);
    presenter_keys_->setEnabled(on);
    if (!on)
        return show_all();
    const auto begins = std::find_if(steps_.begin(), steps_.end(),
        [&](const planner::PresentationStep& step) { return step.approach == model_->selected(); });
    go_to_step(begins == steps_.end() ? 0 : static_cast<std::size_t>(begins - steps_.begin()));
}

std::vector<planner::PresentationStep> MainWindow::steps_now() const
{
    std::vector<planner::PresentedApproach> known;
    for (std::size_t index = 0; index < model_->approach_count(); ++index) {
        const ApproachState& state = model_->state(index);
        const FieldPictures* const field = state.as_draft ? nullptr : state.field.get();
        known.push_back({ .field = field == nullptr ? nullptr : &field->metrics,
            .has_slices = state.closed != nullptr && !state.closed->incision_slices.empty(),
            .divided_bones = field == nullptr ? std::vector<std::string>() : field->divided_bones });
    }
    return planner::presentation_of(model_->planned_case(), known, model_->decisions());
}

/// What is reached is shown by a map of its own; the other steps keep the one that was chosen before.
std::optional<FieldMapKind> MainWindow::map_of_step(const planner::PresentationStep& step) const
{
    return step.view == planner::PresentedView::reached ? FieldMapKind::reach : map_before_conference_;
}

/// What is cut is seen through the wall; the other steps keep the look that was chosen before.
WallLook MainWindow::wall_of_step(const planner::PresentationStep& step) const
{
    return step.view == planner::PresentedView::cut ? WallLook::see_through : wall_before_conference_;
}

/// Another look of the wall is another picture.
void MainWindow::show_wall_as(WallLook look)
{
    if (look == model_->wall_look())
        return;
    model_->set_wall_look(look);
    make_anatomy();
    shown_ = {};
}

void MainWindow::renew_steps()
{
    if (!in_conference() || !model_)
        return;
    const planner::PresentationStep present = steps_[step_];
    steps_ = steps_now();
    const auto same = std::find_if(steps_.begin(), steps_.end(), [&](const planner::PresentationStep& step) {
        return step.approach == present.approach && step.view == present.view && step.title == present.title;
    });
    step_ = same == steps_.end() ? 0 : static_cast<std::size_t>(same - steps_.begin());
    model_->set_map(map_of_step(steps_[step_]));
    show_wall_as(wall_of_step(steps_[step_]));
    conference_bar_->show_step(steps_[step_], step_ + 1, steps_.size());
    show_step_in_notes();
}

void MainWindow::step_by(int steps)
{
    const auto last = static_cast<int>(steps_.size()) - 1;
    go_to_step(static_cast<std::size_t>(std::clamp(static_cast<int>(step_) + steps, 0, last)));
}

void MainWindow::go_to_step(std::size_t number)
{
    if (!in_conference() || number >= steps_.size())
        return;
    const planner::PresentationStep& step = steps_[number];
    model_->set_map(map_of_step(step));
    show_wall_as(wall_of_step(step));
    if (has_own_camera(steps_[step_]) && !has_own_camera(step))
        shown_ = {}; // the same picture is shown from where it was seen first
    step_ = number;
    if (step.approach && model_->selected() != step.approach)
        model_->select(*step.approach);
    model_->set_view(preset_of(step.view));
    model_->set_alone(std::nullopt);
    model_->set_show_opened(shows_opened(step));
    conference_bar_->show_step(step, number + 1, steps_.size());
    conference_bar_->show_note({}); // what was said of an earlier step
    show_step_in_notes();
    hand_out_work();
    show_all();
    show_camera_of_step();
}

void MainWindow::show_camera_of_step()
{
    if (!in_conference() || shown_.pictures == nullptr || !view_->is_drawn())
        return;
    const planner::PresentationStep& step = steps_[step_];
    const bool is_its_own = shown_.view == preset_of(step.view) && shown_.opened == shows_opened(step);
    const QString another = translated(QString("The picture is not that of this step.")); // a key has chosen it
    if (!is_its_own)
        return conference_bar_->show_note(another);
    if (conference_bar_->note() == another)
        conference_bar_->show_note({});
    if (step.kept)
        view_->set_camera(camera_of(*step.kept));
    else if (const auto& closed = model_->shown_state().closed;
             step.view == planner::PresentedView::cut && closed != nullptr)
        view_->set_camera(planned_cut_camera(closed->patient.camera, model_->approach(*step.approach)));
}

void MainWindow::keep_view()
{
    if (!keep_view_->isEnabled() || !view_->is_drawn())
        return;
    const Camera camera = view_->camera(); // as it is now: a plan may finish while the dialog waits
    planner::NamedView kept { .name = {},
        .approach = model_->approach(*model_->selected()).name,
        .opened = model_->shown_source().opened,
        .eye = camera.eye,
        .aim = camera.aim,
        .up = camera.up,
        .view_angle_deg = camera.view_angle_deg };
    const std::vector<planner::NamedView> views = model_->decisions().views;
    const auto taken = [&](const std::string& name) {
        return std::any_of(views.begin(), views.end(),
            [&](const planner::NamedView& view) { return view.name == name && view.approach == kept.approach; });
    };
    std::size_t number = views.size() + 1;
    while (taken("View " + std::to_string(number)))
        ++number;
    const int generation = generation_;
    bool given = false;
    const QString name = QInputDialog::getText(this, translated("Keep this view"), translated("Name of the view:"),
        QLineEdit::Normal, QString("View %1").arg(number), &given)
                             .trimmed();
    if (!given || name.isEmpty() || generation != generation_)
        return;
    kept.name = name.toStdString();
    if (taken(kept.name))
        return show_error({ "there is a view of this name already", kept.name });
    change_decisions([kept](planner::Decisions& decisions) { decisions.views.push_back(kept); },
        "Kept as a step of the conference: " + name);
}

void MainWindow::forget_view()
{
    if (!model_ || model_->decisions().views.empty())
        return;
    const std::vector<planner::NamedView> views = model_->decisions().views;
    const auto spoken = [&](const std::string& name) {
        for (const planner::Approach& approach : model_->planned_case().approaches)
            if (approach.name == name)
                return planner::spoken_name(approach);
        return name; // its approach was removed
    };
    QStringList names;
    for (const planner::NamedView& view : views)
        names += QString::fromStdString(view.name + " (" + spoken(view.approach) + ")");
    const int generation = generation_;
    bool chosen = false;
    const QString name
        = QInputDialog::getItem(this, translated("Forget a view"), translated("View:"), names, 0, false, &chosen);
    const auto at = names.indexOf(name);
    if (!chosen || at < 0 || generation != generation_)
        return;
    change_decisions(
        [forgotten = views[static_cast<std::size_t>(at)]](planner::Decisions& decisions) {
            std::erase_if(decisions.views, [&](const planner::NamedView& view) {
                return view.name == forgotten.name && view.approach == forgotten.approach;
            });
        },
        "Forgotten: " + name);
}

void MainWindow::read_decisions()
{
    try {
        model_->set_decisions(planner::read_decisions(planner::decisions_file(model_->planned_case())));
    } catch (...) { // a damaged file: choosing says so, and leaves it
        show_error(with_controls(current_failure()));
    }
}

/// The choice is shown at once, and kept with the case where this window may write.
void MainWindow::compare(std::size_t id, bool is_compared)
{
    if (!model_)
        return;
    std::size_t index = 0; // the list may be another one since the click
    while (index < model_->approach_count() && model_->id(index) != id)
        ++index;
    const auto names = index < model_->approach_count() ? model_->compared_with(index, is_compared) : std::nullopt;
    if (!names)
        return;
    model_->set_alone(std::nullopt);
    planner::Decisions shown = model_->decisions();
    shown.compared = *names;
    model_->set_decisions(std::move(shown));
    show_all();
    if (!only_looks())
        change_decisions([names = *names](planner::Decisions& decisions) { decisions.compared = names; }, QString(""));
}

void MainWindow::change_decisions(std::function<void(planner::Decisions&)> change, const QString& message)
{
    ++saving_;
    ++deciding_;
    saving_executor_.post([this, generation = generation_, change = std::move(change), message,
                              file = planner::decisions_file(model_->planned_case())](const Job&) {
        std::function<void()> deliver;
        try {
            auto decisions = std::make_shared<planner::Decisions>(planner::read_decisions(file));
            change(*decisions);
            planner::write_decisions(file, *decisions);
            deliver = [this, decisions, message] {
                if (deciding_ == 0) // else a later change holds this one, too
                    model_->set_decisions(*decisions);
                show_all();
                if (message.isNull())
                    show_message(QString::fromStdString(answers_text(*decisions)));
                else if (!message.isEmpty())
                    show_message(message);
            };
        } catch (...) {
            deliver = [this, failure = current_failure()] { show_error(failure); };
        }
        post_back([this, generation, deliver] {
            --saving_;
            --deciding_;
            if (generation == generation_)
                deliver();
        });
    });
}

void MainWindow::choose_approach()
{
    if (!model_ || !model_->selected())
        return;
    const std::size_t index = *model_->selected();
    const planner::Approach& approach = model_->approach(index);
    std::string plan;
    if (const auto& field = model_->state(index).field)
        for (const std::string& sentence : planner::verdict_of(field->metrics).sentences)
            plan += (plan.empty() ? "" : " ") + sentence;
    std::string holding;
    if (const planner::Decisions& decisions = model_->decisions(); !decisions.choices.empty())
        holding = planner::choice_sentence(
            decisions.choices.back(), planner::chosen_name(model_->planned_case(), decisions.choices.back()));
    ChoiceDialog dialog(planner::spoken_name(approach), plan, holding, decided_by_, this);
    const planner::Choice choice { .approach = approach.name, .by = {}, .why = {}, .when = {}, .plan = plan };
    if (dialog.exec() != QDialog::Accepted)
        return;
    decided_by_ = dialog.by();
    change_decisions(
        [choice, by = dialog.by(), why = dialog.why()](planner::Decisions& decisions) {
            decisions.choices.push_back(choice);
            decisions.choices.back().by = by;
            decisions.choices.back().why = why;
            decisions.choices.back().when = planner::utc_text(std::chrono::system_clock::now());
        },
        QString::fromStdString("Chosen: " + planner::spoken_name(approach)));
}

void MainWindow::ask_for_answered_cases()
{
    const QStringList files = QFileDialog::getOpenFileNames(
        this, translated("Cases whose answers are summed up"), {}, translated("Case (case.json *.json)"));
    std::vector<std::filesystem::path> paths;
    for (const QString& file : files)
        paths.emplace_back(file.toStdString());
    if (!paths.empty())
        summarize_answers(paths);
}

void MainWindow::summarize_answers(const std::vector<std::filesystem::path>& case_files)
{
    std::vector<std::vector<planner::Answers>> cases;
    QStringList remarks;
    for (const std::filesystem::path& file : case_files) {
        const QString name = QString::fromStdString(file.parent_path().filename().string());
        try {
            cases.push_back(planner::read_decisions(planner::decisions_file(file)).answers);
            if (cases.back().empty())
                remarks += name + ": nobody has answered yet";
        } catch (const Error& error) {
            remarks += name + ": " + error.what();
        }
    }
    auto* dialog = new SummaryDialog(cases, remarks.join('\n'), this);
    dialog->setAttribute(Qt::WA_DeleteOnClose);
    dialog->open();
}

void MainWindow::ask_questions()
{
    if (!model_)
        return;
    AnswersDialog dialog(decided_by_, this);
    if (dialog.exec() != QDialog::Accepted)
        return;
    decided_by_ = dialog.answers().by;
    change_decisions(
        [answers = dialog.answers()](planner::Decisions& decisions) {
            decisions.answers.push_back(answers);
            decisions.answers.back().when = planner::utc_text(std::chrono::system_clock::now());
        },
        {});
}

} // namespace retractor::ui
