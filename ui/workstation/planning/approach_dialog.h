#pragma once
// Asks for a new approach, or for another target or opening of an existing one.

#include "planner/approach/approach_draft.h"

#include <QDialog>

#include <functional>
#include <string>
#include <utility>
#include <vector>

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QFormLayout;
class QLabel;
class QLineEdit;
class QPushButton;
class QSpinBox;

namespace retractor::ui {

class ApproachDialog : public QDialog {
public:
    /// A label that may be the target: its name in the case, and in words.
    using Target = std::pair<std::string, std::string>;

    enum class Asks {
        kind, ///< a new approach by a template
        drawn, ///< what an incision that was drawn divides
        opening, ///< target and opening of an existing approach
    };

    ApproachDialog(Asks asks, const std::vector<Target>& targets, QWidget* parent);

    /// Shows name, target and opening of a draft. @pre its target is one of the targets
    void show_draft(const planner::ApproachDraft& draft);
    /// Shown in place of an empty name.
    void set_usual_name(const QString& name);
    /// Names the hooks or the retractor that the approach has now. @pre Asks::opening
    void set_present_instrument(const QString& words);
    /// The draft as it stands now; its points are those shown. Where hooks or retractor stay, the opening is that of
    /// the field, and 0 where they have none.
    planner::ApproachDraft draft() const;
    /// Whether hooks or retractor stay. Only where an existing approach is changed.
    bool keeps_opening() const;
    /// Shows why the approach could not be made; the dialog stays open.
    void show_failure(const QString& text);
    /// While the approach is made nothing can be pressed but Cancel.
    void set_busy(bool busy);

    std::function<void()> on_accept; ///< set by the owner; called where the user asks for the approach

private:
    void add_kind(QFormLayout& form);
    void add_drawn(QFormLayout& form);
    void add_target_and_opening(QFormLayout& form, const std::vector<Target>& targets);
    void show_what_applies();

    Asks asks_;
    planner::ApproachDraft shown_;
    QComboBox *kind_ = nullptr, *side_ = nullptr, *divides_ = nullptr, *target_ = nullptr, *opened_by_ = nullptr;
    QSpinBox* space_ = nullptr;
    int chosen_side_ = 0; ///< of the kinds that have two
    QCheckBox* organs_aside_ = nullptr;
    QDoubleSpinBox *depth_ = nullptr, *opening_ = nullptr;
    QLineEdit* name_ = nullptr;
    QLabel* failure_ = nullptr;
    QPushButton* accept_ = nullptr;
    bool opening_touched_ = false; ///< the user has set the opening
    double opening_shown_mm_ = 0.0; ///< as show_draft() showed it, rounded
};

/// The labels that a surgeon may aim at: targets first, then organs; neither bones nor layers of the wall.
std::vector<ApproachDialog::Target> possible_targets(const planner::Case& planned_case);

} // namespace retractor::ui
