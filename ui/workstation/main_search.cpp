// The search for an incision in the main window, and the weights of its score.

#include "mesh/base/error.h"
#include "planner/approach/approach_draft.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/planning/metrics_panel.h"
#include "ui/workstation/planning/search_dialog.h"
#include "ui/workstation/planning/weights_dialog.h"

#include <QDialog>

#include <vector>

namespace retractor::ui {

void MainWindow::search_incisions()
{
    if (search_dialog_ != nullptr) {
        search_dialog_->raise();
        return search_dialog_->activateWindow();
    }
    auto* dialog = new SearchDialog(model_->planned_case(), model_->weights(), backend_.search, this);
    search_dialog_ = dialog;
    dialog->setAttribute(Qt::WA_DeleteOnClose);
    dialog->on_take = [this](const std::vector<planner::Proposal>& taken) {
        if (editor_->drawing())
            throw InputError("an incision is being drawn: finish or discard it first");
        planner::Case present = model_->planned_case();
        const std::size_t before = present.approaches.size();
        planner::add_proposals(present, taken);
        const std::vector<planner::Approach> added(
            present.approaches.begin() + static_cast<std::ptrdiff_t>(before), present.approaches.end());
        const std::string what = added.size() == 1 ? planner::spoken_name(added.front()) : "proposals";
        model_->add_approaches(added, "add " + what);
        model_->select(before);
        editor_->on_edit();
        show_message("Added: plan with P, compare with 5.");
    };
    dialog->show(); // the window can be used meanwhile
}

void MainWindow::close_case_dialogs()
{
    if (search_dialog_ != nullptr)
        search_dialog()->abandon();
    search_dialog_.clear(); // it ends when its search does
    if (weights_dialog_ != nullptr)
        weights_dialog_->close();
    weights_dialog_.clear();
}

SearchDialog* MainWindow::search_dialog() const { return static_cast<SearchDialog*>(search_dialog_.data()); }

void MainWindow::change_weights()
{
    if (weights_dialog_ != nullptr) {
        weights_dialog_->raise();
        return weights_dialog_->activateWindow();
    }
    auto* dialog = new WeightsDialog(model_->weights(), this);
    weights_dialog_ = dialog;
    dialog->setAttribute(Qt::WA_DeleteOnClose);
    dialog->on_change = [this](const planner::Weights& weights) {
        model_->set_weights(weights);
        panel_->show_model(model_.get());
    };
    dialog->show();
}

} // namespace retractor::ui
