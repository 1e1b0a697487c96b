// The tour of the main window: eight steps that show and say what it does.

#include "planner/case/case.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/start/case_folder.h"
#include "ui/workstation/view/step_bar.h"

#include <QTabWidget>

#include <array>

namespace retractor::ui {

namespace {

    /// A step says one thing to do. The window shows where.
    struct TourStep {
        const char *title, *text;
        ViewPreset view;
        bool opened;
        WallLook wall;
    };

    constexpr std::array kTour {
        TourStep { "The patient",
            "The list on the left has the approaches of this case; the blue line is the incision. Drag in the picture "
            "to "
            "turn it, use the wheel to zoom, 0 shows it as before.",
            ViewPreset::overview, false, WallLook::solid },
        TourStep { "Looking inside",
            "W looks through the wall, and hides it. Click on a bone or a vessel: the line at the bottom says what it "
            "is. "
            "V cuts the patient away; Shift and the wheel move the cut.",
            ViewPreset::overview, false, WallLook::see_through },
        TourStep { "Slices",
            "Click on a slice: the others move there. The wheel goes from slice to slice, Shift+1 to Shift+4 change "
            "the "
            "greys. T makes the place where they meet the target.",
            ViewPreset::slices, false, WallLook::solid },
        TourStep { "The incision",
            "Cyan is the blade. Drag its end on the slice across the incision, and it goes deeper or another way. In "
            "the "
            "pictures in space, M moves the points of the incision, N adds an approach. Ctrl+Z takes everything back.",
            ViewPreset::incision, false, WallLook::solid },
        TourStep { "The plan",
            "P cuts the wall, opens the wound with the retractor and measures what is seen. This takes one or two "
            "minutes; "
            "go on meanwhile. The numbers come on the right, the worst first; a red light means: do not do this.",
            ViewPreset::surgeon, true, WallLook::solid },
        TourStep { "What the surgeon sees",
            "This is the view through the incision from the best place of the eye; the target is green. O switches "
            "between "
            "before and after the cut, Ctrl+1 to Ctrl+6 show numbers as colours, 6 and 7 look through an endoscope.",
            ViewPreset::surgeon, true, WallLook::solid },
        TourStep { "By hand",
            "K is the knife: draw a cut on the skin. H sets hooks on its edges; drag them, and the panel says which "
            "force "
            "they bear and how much of the target is seen. Esc puts the knife away.",
            ViewPreset::overview, false, WallLook::solid },
        TourStep { "Deciding",
            "Shift+P plans all approaches, 5 compares them, Ctrl+F searches for better ones. F5 shows the plans in the "
            "case conference, Ctrl+R saves the report. F1 opens the manual at what is shown.",
            ViewPreset::compare, true, WallLook::solid },
    };

} // namespace

void MainWindow::make_tour()
{
    tour_bar_->on_step = [this](int by) {
        if (tour_step_)
            go_to_tour_step(static_cast<std::size_t>(static_cast<int>(*tour_step_) + by));
    };
    tour_bar_->on_end = [this] { end_tour(); };
}

void MainWindow::begin_tour()
{
    if (!model_) {
        const std::filesystem::path folder = free_case_folder("demo-patient");
        tour_case_ = folder / planner::kCaseFileName;
        return open_demo_patient(folder);
    }
    set_conference(false);
    set_measuring(false);
    go_to_tour_step(0);
}

void MainWindow::go_to_tour_step(std::size_t step)
{
    if (step >= kTour.size())
        return;
    tour_step_ = step;
    const TourStep& shown = kTour.at(step);
    editor_->abandon();
    tabs_->setCurrentIndex(0);
    set_knife(KnifeMode::away);
    model_->set_show_opened(shown.opened);
    model_->set_alone(std::nullopt);
    model_->set_wall_look(shown.wall);
    model_->set_cut_side(std::nullopt);
    if (model_->view_available(shown.view))
        model_->set_view(shown.view);
    make_anatomy();
    tour_bar_->show_step({ .title = shown.title, .text = shown.text }, step + 1, kTour.size());
    tour_bar_->show();
    show_all();
    reset_view(); // the look of the wall may be another
}

void MainWindow::end_tour()
{
    if (!in_tour())
        return;
    tour_step_.reset();
    tour_bar_->hide();
    show_all();
}

} // namespace retractor::ui
