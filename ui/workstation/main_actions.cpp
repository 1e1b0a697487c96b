// The actions of the main window: menus, keys, tool bar and buttons.

#include "ui/scene/linked_slices.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/view/controls.h"

#include <QActionGroup>
#include <QColor>
#include <QGridLayout>
#include <QIcon>
#include <QMenuBar>
#include <QPainter>
#include <QPen>
#include <QPixmap>
#include <QPolygonF>
#include <QToolBar>
#include <QToolButton>

#include <functional>
#include <utility>

namespace retractor::ui {

namespace {

    /// Two light arrows to the right, where the style's own are black on a dark bar.
    QIcon more_icon()
    {
        constexpr int kSide = 16, kSharp = 2; // for screens with two pixels to a point
        QPixmap pixmap(kSharp * kSide, kSharp * kSide);
        pixmap.setDevicePixelRatio(kSharp);
        pixmap.fill(Qt::transparent);
        QPainter painter(&pixmap);
        painter.setRenderHint(QPainter::Antialiasing);
        painter.setPen(QPen(QColor("#e4e8eb"), 2.0));
        for (const qreal x : { 2.0, 8.0 })
            painter.drawPolyline(QPolygonF({ { x, 3.0 }, { x + 5.0, 8.0 }, { x, 13.0 } }));
        return pixmap;
    }

} // namespace

QAction* MainWindow::add_action(
    QMenu& menu, const QString& text, const QKeySequence& key, const QString& tip, std::function<void()> run)
{
    QAction* action = menu.addAction(translated(text));
    action->setShortcut(key);
    const QString said = translated(tip);
    action->setToolTip(key.isEmpty() ? said : said + " (" + key.toString(QKeySequence::NativeText) + ")");
    connect(action, &QAction::triggered, this, [run = std::move(run)] { run(); });
    return action;
}

void MainWindow::make_actions()
{
    make_file_actions(*menuBar()->addMenu("&File"));
    make_view_actions(*menuBar()->addMenu("&View"));
    make_approach_actions(*menuBar()->addMenu("&Approach"));
    make_knife_actions(*menuBar()->addMenu("&Knife"));
    QMenu* help = menuBar()->addMenu("&Help");
    QAction* const manual = add_action(
        *help, "Manual", QKeySequence::HelpContents, "Open the manual at what is shown", [this] { open_manual(); });
    add_action(*help, "Tour", {}, "See in eight steps what this window does", [this] { begin_tour(); });
    add_action(*help, "Save the log…", {}, "What the window said, to be attached to a report of a fault",
        [this] { ask_for_log_file(); });
    add_action(*help, "About Retractor", {}, "Show the version and the licence", [this] { show_about(); });
    make_language_actions(*help);
    // Keys that work without the menus, in a conference.
    addActions({ surgeon_, overview_, slices_, incision_, compare_, opened_, cancel_, confer_, movie_, report_, linked_,
        reset_view_, keep_view_, notes_action_, manual });
    make_tool_bar();
}

/// The language is that of the window's next start: texts that are shown now were composed in this one.
void MainWindow::make_language_actions(QMenu& menu)
{
    QMenu* const languages = menu.addMenu("Language");
    auto* const group = new QActionGroup(this);
    for (const Language& one : kLanguages) {
        QAction* const action
            = add_action(*languages, one.name, {}, "The language of the window, from the next start on", [this, one] {
                  prefer_language(one.code);
                  show_message(QString("The window speaks %1 from its next start on.").arg(one.name));
              });
        action->setCheckable(true);
        action->setChecked(language() == one.code);
        group->addAction(action);
    }
}

void MainWindow::make_file_actions(QMenu& menu)
{
    add_action(menu, "Import a study…", QKeySequence("Ctrl+I"), "Make a case from a CT", [this] { import_study(); });
    add_action(menu, "Open case…", QKeySequence::Open, "Open a case.json", [this] { ask_for_case(); });
    close_case_
        = add_action(menu, "Close case", QKeySequence("Ctrl+W"), "Go back to the start page", [this] { close_case(); });
    menu.addSeparator();
    save_ = add_action(
        menu, "Save picture…", QKeySequence::Save, "Save the picture as PNG", [this] { ask_for_picture_file(); });
    movie_ = add_action(menu, "Save a movie…", QKeySequence("Ctrl+M"),
        "Save a movie of the plans: cut, opened, seen through the incision, and reached",
        [this] { ask_for_movie_file(); });
    report_ = add_action(menu, "Save the report…", QKeySequence("Ctrl+R"),
        "Save the plans with numbers and pictures as a page for the browser", [this] { ask_for_report_file(); });
    palpate_ = add_action(menu, "Palpate a structure…", {}, "Palpate a vessel or an organ of this case in a new window",
        [this] { ask_for_structure(); });
    palpate_through_ = add_action(menu, "Palpate through the wound", QKeySequence("Ctrl+T"),
        "Touch the target of the planned approach through its opened wound, in a new window",
        [this] { palpate_through_wound(); });
    menu.addSeparator();
    add_action(menu, "Quit", QKeySequence::Quit, "Close the window", [this] { close(); });
}

void MainWindow::make_view_actions(QMenu& menu)
{
    surgeon_ = add_action(
        menu, "Surgeon's eye", Qt::Key_1, "View through the incision", [this] { set_view(ViewPreset::surgeon); });
    overview_ = add_action(
        menu, "Overview", Qt::Key_2, "View of the patient from outside", [this] { set_view(ViewPreset::overview); });
    slices_ = add_action(
        menu, "Slices", Qt::Key_3, "Three planes of the CT and the overview", [this] { set_view(ViewPreset::slices); });
    incision_ = add_action(menu, "Incision", Qt::Key_4, "Slices along and across the incision, with the cut",
        [this] { set_view(ViewPreset::incision); });
    compare_
        = add_action(menu, "Compare", Qt::Key_5, "Two to four planned approaches beside each other, with their numbers",
            [this] { set_view(ViewPreset::compare); });
    auto* presets = new QActionGroup(this);
    for (QAction* action : { surgeon_, overview_, slices_, incision_, compare_ }) {
        action->setCheckable(true);
        presets->addAction(action);
    }
    menu.addSeparator();
    grey_windows_ = new QActionGroup(this);
    for (std::size_t i = 0; i < kGreyWindows.size(); ++i) {
        const GreyWindow& grey = kGreyWindows[i];
        QAction* action = add_action(menu, grey.name, QKeySequence("Shift+" + QString::number(i + 1)),
            QString("Slices from %1 to %2 HU")
                .arg(grey.level_hu - 0.5 * grey.window_hu)
                .arg(grey.level_hu + 0.5 * grey.window_hu),
            [this, i] { set_grey_window(i); });
        action->setCheckable(true);
        grey_windows_->addAction(action);
    }
    menu.addSeparator();
    label_looks_ = new QActionGroup(this);
    const auto add_look = [&](LabelLook look, const QString& text, const QKeySequence& key, const QString& tip) {
        QAction* action = add_action(menu, text, key, tip, [this, look] { set_label_look(look); });
        action->setCheckable(true);
        label_looks_->addAction(action);
    };
    add_look(LabelLook::filled, "Labels filled", QKeySequence("Shift+F"), "Slices with labels in their colours");
    add_look(LabelLook::outlined, "Labels outlined", QKeySequence("Shift+O"), "Slices with the outlines of the labels");
    add_look(LabelLook::hidden, "No labels", QKeySequence("Shift+N"), "Slices of the CT alone");
    menu.addSeparator();
    QMenu* colours = menu.addMenu("Colours of the opened field");
    maps_ = new QActionGroup(this);
    const auto add_map = [&](const QString& text, const QKeySequence& key, std::optional<FieldMapKind> map) {
        QAction* action = add_action(*colours, text, key, "Colours: " + text, [this, map] { set_map(map); });
        action->setCheckable(true);
        action->setData(map ? static_cast<int>(*map) : -1);
        maps_->addAction(action);
    };
    add_map("Tissues", QKeySequence("Ctrl+0"), std::nullopt);
    for (std::size_t i = 0; i < kFieldMaps.size(); ++i)
        add_map(kFieldMaps.at(i).words, QKeySequence("Ctrl+" + QString::number(i + 1)), kFieldMaps.at(i).kind);
    make_look_actions(menu);
    opened_ = add_action(
        menu, "Opened", Qt::Key_O, "Switch between the opened field and the patient before the cut", [this] {
            model_->set_show_opened(opened_->isChecked());
            show_picture();
        });
    opened_->setCheckable(true);
    linked_ = add_action(menu, "Turn together", QKeySequence("Shift+T"),
        "In the comparison, all pictures turn and zoom with the one under the mouse", [this] {
            show_linked();
            show_message(linked_->isChecked() ? "The pictures turn together" : "Each picture turns alone");
        });
    linked_->setCheckable(true);
    linked_->setChecked(true);
    reset_view_ = add_action(menu, "Reset the view", Qt::Key_0, "Show the picture again from where it was seen first",
        [this] { reset_view(); });
    keep_view_ = add_action(menu, "Keep this view…", QKeySequence("Shift+V"),
        "Keep the view as a step of the conference and of movies", [this] { keep_view(); });
    forget_view_
        = add_action(menu, "Forget a kept view…", {}, "Remove a view that was kept", [this] { forget_view(); });
    measure_ = add_action(menu, "Measure", Qt::Key_R, "Measure distances and angles on slices or on the skin",
        [this] { set_measuring(measure_->isChecked()); });
    measure_->setCheckable(true);
    measure_area_ = add_action(menu, "Measure an area", QKeySequence("Shift+R"),
        "Measure an area on slices or on the skin: click its corners",
        [this] { set_measuring(measure_area_->isChecked(), true); });
    measure_area_->setCheckable(true);
    forget_measurements_ = add_action(menu, "Remove the measurements", {}, "Remove all distances, angles and areas",
        [this] { forget_measurements(); });
    correct_ = add_action(menu, "Correct labels", Qt::Key_C, "Paint, erase and rename labels on the slices",
        [this] { correct_labels(); });
    menu.addSeparator();
    confer_ = add_action(menu, "Conference", Qt::Key_F5, "Full screen, large type: the plans step by step",
        [this] { set_conference(confer_->isChecked()); });
    confer_->setCheckable(true);
    notes_action_ = add_action(menu, "Notes", Qt::Key_F6,
        "In the conference: the presenter's notes, on a second screen where there is one",
        [this] { show_notes(notes_action_->isChecked()); });
    notes_action_->setCheckable(true);
}

void MainWindow::make_approach_actions(QMenu& menu)
{
    new_approach_
        = add_action(menu, "New…", Qt::Key_N, "Add a standard approach", [this] { editor_->add_from_template(); });
    draw_ = add_action(menu, "Draw", Qt::Key_D, "Draw an incision on the skin: click its points, or drag along it",
        [this] { draw_incision(); });
    draw_->setCheckable(true);
    move_ = add_action(menu, "Move", Qt::Key_M, "Drag the points of the incision", [this] { move_incision(); });
    move_->setCheckable(true);
    finish_ = add_action(menu, "Finish the incision", Qt::Key_Return, "End drawing or moving", [this] { finish(); });
    finish_->setShortcuts({ QKeySequence(Qt::Key_Return), QKeySequence(Qt::Key_Enter) });
    menu.addSeparator();
    change_ = add_action(menu, "Target and opening…", Qt::Key_E, "Change the target, the retractor or the name",
        [this] { editor_->change_opening(); });
    site_ = add_action(menu, "Target here…", Qt::Key_T,
        "Make the marked place, where the slices meet, the target: an anastomosis, a clamp, a neck, an annulus",
        [this] { editor_->choose_site(); });
    duplicate_ = add_action(menu, "Duplicate", QKeySequence("Ctrl+D"), "Add a copy", [this] { editor_->duplicate(); });
    neighbours_ = add_action(menu, "Add neighbours", Qt::Key_B,
        "Add the same approach one space higher and lower, and 20 mm along", [this] { editor_->add_neighbours(); });
    search_ = add_action(menu, "Search…", QKeySequence("Ctrl+F"),
        "Search for an incision that shows the target: which space, where, how long, or through the sternum",
        [this] { search_incisions(); });
    remove_ = add_action(menu, "Remove", QKeySequence::Delete, "Remove this approach", [this] { editor_->remove(); });
    menu.addSeparator();
    weights_ = add_action(menu, "Weights…", QKeySequence("Shift+W"),
        "How much each criterion counts in the score of the comparison", [this] { change_weights(); });
    choose_ = add_action(menu, "Choose…", QKeySequence("Shift+C"),
        "Record that the team chooses this approach, and why", [this] { choose_approach(); });
    questions_ = add_action(menu, "Six questions…", QKeySequence("Shift+Q"),
        "Answer the questions about the planned field", [this] { ask_questions(); });
    add_action(menu, "Answers over cases…", {}, "Sum up the answers to the six questions over several cases",
        [this] { ask_for_answered_cases(); });
    menu.addSeparator();
    plan_
        = add_action(menu, "Plan", Qt::Key_P, "Cut, open and measure this approach", [this] { plan_selected(false); });
    draft_ = add_action(menu, "Plan a draft", QKeySequence("Ctrl+P"),
        "Cut, open and measure this approach quickly, on a coarse model and without errors; a draft is not saved",
        [this] { plan_selected(true); });
    plan_all_ = add_action(
        menu, "Plan all", QKeySequence("Shift+P"), "Cut, open and measure all approaches", [this] { plan_all(); });
    cancel_ = add_action(menu, "Cancel", Qt::Key_Escape,
        "Discard the open stroke or incision, end measuring, or stop what is being computed", [this] { cancel(); });
}

void MainWindow::make_knife_actions(QMenu& menu)
{
    const auto add_mode
        = [&](QAction*& action, const QString& text, const QKeySequence& key, const QString& tip, KnifeMode mode) {
              action = add_action(menu, text, key, tip,
                  [this, mode, &action] { set_knife(action->isChecked() ? mode : KnifeMode::away); });
              action->setCheckable(true);
          };
    add_mode(knife_action_, "Knife", Qt::Key_K, "Draw cuts on the skin with the left button", KnifeMode::freehand);
    add_mode(line_action_, "Line", Qt::Key_L, "Cut straight between two clicks", KnifeMode::line);
    add_mode(hook_action_, "Hooks", Qt::Key_H, "Press on the edge of a wound to set a hook; drag a hook to pull it",
        KnifeMode::hooks);
    add_mode(take_out_action_, "Take out", Qt::Key_X, "Press on a loose piece or on tissue to remove it",
        KnifeMode::take_out);
    menu.addSeparator();
    undo_ = add_action(menu, "Undo", QKeySequence::Undo, "Take the last step back", [this] { undo(); });
    redo_ = add_action(menu, "Redo", QKeySequence("Ctrl+Shift+Z"), "Make the step again", [this] { redo(); });
}

void MainWindow::make_tool_bar()
{
    tool_bar_ = addToolBar("Tools");
    QToolBar* bar = tool_bar_;
    bar->setMovable(false);
    bar->setContextMenuPolicy(Qt::PreventContextMenu);
    if (auto* more = bar->findChild<QToolButton*>("qt_toolbar_ext_button")) { // where the window is narrow
        more->setIcon(more_icon());
        more->setToolTip(translated("More tools"));
    }
    int key = 1;
    for (QAction* action : { surgeon_, overview_, slices_, incision_, compare_ })
        action->setIconText(QString::number(key++) + "  " + action->text());
    bar->addActions({ surgeon_, overview_, slices_, incision_, compare_ });
    bar->addSeparator();
    bar->addActions({ opened_, measure_ });
    bar->addSeparator();
    bar->addActions({ plan_, plan_all_ });
    bar->addSeparator();
    bar->addActions({ knife_action_, line_action_, hook_action_, take_out_action_ });
    bar->addSeparator();
    bar->addActions({ undo_, redo_ });
    change_->setIconText(translated("Change…"));
    int place = 0;
    for (QAction* action : { new_approach_, draw_, move_, change_ }) {
        auto* button = unfocused(new QToolButton, action->toolTip());
        button->setDefaultAction(action);
        button->setToolButtonStyle(Qt::ToolButtonTextOnly);
        button->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed); // the pane may be narrow
        button->setObjectName("narrow");
        approach_buttons_->addWidget(button, place / 2, place % 2);
        ++place;
    }
}

} // namespace retractor::ui
