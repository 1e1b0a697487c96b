#pragma once
// The panel on the right while cutting: the knife's settings and the list of cuts, and below them the hooks and their
// numbers.

#include "planner/session/surgery_command.h"
#include "planner/session/surgery_worker.h"

#include <QScrollArea>

#include <functional>
#include <optional>
#include <vector>

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QFormLayout;
class QHBoxLayout;
class QLabel;
class QListWidget;
class QPushButton;
class QSlider;

namespace retractor::ui {

class KnifePanel : public QScrollArea {
public:
    explicit KnifePanel(QWidget* parent = nullptr);

    planner::KnifeSettings settings() const;
    double removal_radius_mm() const; ///< radius of the tissue that Remove deletes; 0: a loose piece
    /// What the hook tool sets on a wound: an instrument of the table; nothing: a hook.
    std::optional<planner::RetractorKind> instrument() const;
    double tension() const; ///< chosen tension, as a strain
    void set_tension(double strain); ///< chooses one of the offered tensions
    /// Adds the tension of the case, with which its plans are made, to the choices. The panel then uses this tension,
    /// unless the user chose another one for the case. 0: the case has none.
    void offer_case_tension(double strain);
    /// @param snapshot null: there is no session
    void show_snapshot(const planner::SurgerySnapshot* snapshot, double draw_ms);
    /// What is seen of the target through the wound; empty: nothing is known.
    void show_sight(const QString& text);
    QString sight_text() const; ///< text on the panel

    // Set by the owner; called when something is pressed or set.
    std::function<void(planner::surgery::Command)> on_command;
    std::function<void()> on_export;
    /// Called with a retractor that shall be planned as it is cranked, and the place between its blades at rest.
    std::function<void(const planner::RetractorState&, const Vec3& at)> on_plan_retractor;
    std::function<void(bool wanted)> on_restore;
    double yield_N() const; ///< force at which hooks yield; infinite: never
    bool nonlinear() const;

    QDoubleSpinBox& depth() { return *depth_; }
    QComboBox& removal() { return *removal_; }
    QListWidget& list() { return *cuts_; }
    QComboBox& instruments() { return *instrument_; }
    QSlider& opening() { return *opening_; }
    QDoubleSpinBox& yield() { return *yield_; }
    QCheckBox& nonlinear_box() { return *nonlinear_; }
    QString opening_text() const; ///< text beside the slider
    QListWidget& hook_list() { return *hooks_; }
    QPushButton& cut_planned_button() { return *cut_planned_; }
    QPushButton& divide_button() { return *divide_; }
    QPushButton& planned_hooks_button() { return *planned_; }
    QPushButton& plan_retractor_button() { return *to_plan_; }
    QString hook_numbers() const; ///< text on the panel
    QString technical_text() const; ///< text that the panel shows where Technical is ticked
    QCheckBox& technical_box() { return *technical_; }
    QString hook_warning() const; ///< text on the panel; empty: none
    QPushButton& restore_button() { return *restore_; }
    QPushButton& discard_button() { return *discard_; }

protected:
    bool eventFilter(QObject* watched, QEvent* event) override;

private:
    QWidget* make_question();
    QFormLayout* make_settings();
    QHBoxLayout* make_planned_cuts();
    void show_planned_cuts(const planner::SurgerySnapshot* snapshot);
    QHBoxLayout* make_buttons();
    QListWidget* make_cut_list();
    QWidget* make_hooks();
    void give(planner::surgery::Command command);
    void take_planned_tension();
    void take_off_chosen_hook();
    void plan_chosen_retractor();
    void show_hooks(const planner::SurgerySnapshot* snapshot);
    void show_opening(const planner::HookReport& report);
    void set_opening(int value, bool by_share);
    static QString solver_text(const planner::HookReport& report);
    QString opening_text(int value) const;
    QDoubleSpinBox* depth_ = nullptr;
    QCheckBox *through_ = nullptr, *bone_ = nullptr, *nonlinear_ = nullptr;
    QComboBox *tension_ = nullptr, *removal_ = nullptr, *instrument_ = nullptr;
    int case_tension_item_ = -1; ///< index of the case's tension in tension_; -1: none
    bool tension_by_hand_ = false; ///< the user chose a tension, so the case's tension does not replace it
    QListWidget* cuts_ = nullptr;
    QWidget* question_ = nullptr; ///< question whether to restore the cuts of the last session
    QLabel* question_text_ = nullptr;
    QPushButton *restore_ = nullptr, *discard_ = nullptr;
    QPushButton *cut_planned_ = nullptr, *divide_ = nullptr;
    QPushButton *undo_ = nullptr, *redo_ = nullptr, *export_ = nullptr;
    QLabel *state_ = nullptr, *sight_ = nullptr, *solver_ = nullptr;
    QCheckBox* technical_ = nullptr;
    QSlider* opening_ = nullptr;
    QLabel* opening_text_ = nullptr;
    bool by_share_ = false; ///< the slider shows per cent of the plan instead of mm
    QDoubleSpinBox* yield_ = nullptr;
    QListWidget* hooks_ = nullptr;
    std::vector<fem::HookId> hook_ids_; ///< id of each entry of the list
    planner::HookReport report_; ///< that is shown
    int widest_mm_ = 0; ///< to which the slider opens, on each side
    QPushButton *planned_ = nullptr, *to_plan_ = nullptr, *hook_off_ = nullptr, *hooks_off_ = nullptr;
    QLabel *numbers_ = nullptr, *refusal_ = nullptr;
};

} // namespace retractor::ui
