#pragma once
// Searches for incisions: asks for target and limits, searches on its own thread, shows what is proposed, and hands
// over what the user takes.

#include "mesh/base/serial_executor.h"
#include "ui/workstation/planning/planning_backend.h"

#include <QDialog>
#include <QElapsedTimer>
#include <QTimer>

#include <functional>
#include <memory>
#include <vector>

class QCheckBox;
class QComboBox;
class QLabel;
class QProgressBar;
class QPushButton;
class QSpinBox;
class QStackedWidget;
class QTableWidget;

namespace retractor::ui {

class SearchDialog : public QDialog {
public:
    using Search = std::function<FoundProposals(const planner::Case&, const planner::SearchRequest&, const Job&)>;

    SearchDialog(planner::Case planned_case, const planner::Weights& weights, Search search, QWidget* parent);

    planner::SearchRequest request() const;
    void search();
    /// Takes the proposals that are ticked.
    void take();
    bool idle() const { return !working_; }
    /// Why the last search failed; empty: it did not.
    QString failure() const;
    /// Cancels the search and closes. The dialog deletes itself when the search has ended, so that nobody waits for it.
    void abandon();

    /// Called with the proposals that the user takes. A failure is shown, and the dialog stays open.
    std::function<void(const std::vector<planner::Proposal>&)> on_take;

protected:
    void reject() override; ///< cancels the search, or closes

private:
    QWidget* make_request();
    QWidget* make_answer();
    void show_answer(FoundProposals found);
    void show_failure(const QString& text);
    void show_progress();
    void show_what_applies();

    planner::Case case_;
    planner::Weights weights_;
    Search search_;
    FoundProposals found_;
    bool working_ = false, cancelling_ = false, abandoned_ = false;

    QStackedWidget* pages_ = nullptr;
    QComboBox *target_ = nullptr, *side_ = nullptr;
    QSpinBox *highest_ = nullptr, *lowest_ = nullptr, *shortest_ = nullptr, *longest_ = nullptr;
    QCheckBox* saw_ = nullptr;
    QTableWidget* table_ = nullptr;
    QLabel *map_ = nullptr, *remarks_ = nullptr, *failure_ = nullptr, *work_ = nullptr;
    QProgressBar* progress_ = nullptr;
    QPushButton *search_button_ = nullptr, *take_button_ = nullptr, *back_ = nullptr, *close_ = nullptr;
    QTimer timer_;
    QElapsedTimer watch_;
    SerialExecutor executor_; ///< declared last: its tasks use the other members
};

} // namespace retractor::ui
