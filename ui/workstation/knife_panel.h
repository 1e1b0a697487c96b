#pragma once
// The knife's settings and the list of cuts, on the right; below, the hooks and their numbers.

#include "planner/session/knife_worker.h"

#include <QWidget>

#include <functional>

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QLabel;
class QListWidget;
class QPushButton;
class QSlider;

namespace retractor {

class KnifePanel : public QWidget {
public:
    explicit KnifePanel(QWidget* parent = nullptr);

    KnifeSettings settings() const;
    double removal_radius_mm() const; ///< of what is taken out; 0: a piece that was cut free
    double tension() const; ///< strain
    void set_tension(double strain); ///< one of those offered
    /// Among the others, and takes it: what the case's plans are made with. 0: the case has none.
    void offer_case_tension(double strain);
    /// @param news null: there is no table laid out.
    void show_news(const KnifeNews* news, double draw_ms);

    // Set by the owner; called when a button is pressed.
    std::function<void()> on_undo, on_redo, on_export, on_tension;
    std::function<void(bool wanted)> on_restore;
    std::function<void()> on_planned_hooks, on_hooks_off, on_yield, on_nonlinear;
    /// Every hook, each along its own pull; or, where one pulls with a force, all by a share of their plan.
    std::function<void(double mm)> on_open;
    std::function<void(double share)> on_share;
    std::function<void(std::size_t)> on_hook_off; ///< by its place in the list
    double yield_N() const; ///< infinite: never
    bool nonlinear() const;
    /// How many cuts are to be in force: an entry of the list was activated.
    std::function<void(std::size_t)> on_go_to;

    QDoubleSpinBox& depth() { return *depth_; }
    QComboBox& removal() { return *removal_; }
    QListWidget& list() { return *cuts_; }
    QSlider& opening() { return *opening_; }
    QDoubleSpinBox& yield() { return *yield_; }
    QCheckBox& nonlinear_box() { return *nonlinear_; }
    QString opening_text() const; ///< beside the slider
    QListWidget& hook_list() { return *hooks_; }
    QPushButton& planned_hooks_button() { return *planned_; }
    QPushButton& hook_off_button() { return *hook_off_; }
    QPushButton& hooks_off_button() { return *hooks_off_; }
    QString hook_numbers() const; ///< as shown
    QString hook_warning() const; ///< as shown; empty: none
    QPushButton& restore_button() { return *restore_; }
    QPushButton& discard_button() { return *discard_; }

protected:
    bool eventFilter(QObject* watched, QEvent* event) override;

private:
    QWidget* make_question();
    QWidget* make_hooks();
    void show_hooks(const KnifeNews* news);
    void show_opening(const std::vector<HookState>& hooks);
    void set_opening(int value, bool by_share);
    QString opening_text(int value) const;
    QDoubleSpinBox* depth_ = nullptr;
    QCheckBox *through_ = nullptr, *bone_ = nullptr, *nonlinear_ = nullptr;
    QComboBox *tension_ = nullptr, *removal_ = nullptr;
    int case_tension_item_ = -1; ///< of tension_; -1: none
    bool tension_by_hand_ = false; ///< chosen for this case: the case's own does not replace it
    QListWidget* cuts_ = nullptr;
    QWidget* question_ = nullptr; ///< restore the cuts of the last time?
    QLabel* question_text_ = nullptr;
    QPushButton *restore_ = nullptr, *discard_ = nullptr;
    QPushButton *undo_ = nullptr, *redo_ = nullptr, *export_ = nullptr;
    QLabel* state_ = nullptr;
    QSlider* opening_ = nullptr;
    QLabel* opening_text_ = nullptr;
    bool by_share_ = false; ///< the slider is in per cent of the plan, not in mm
    QDoubleSpinBox* yield_ = nullptr;
    QListWidget* hooks_ = nullptr;
    QPushButton *planned_ = nullptr, *hook_off_ = nullptr, *hooks_off_ = nullptr;
    QLabel *numbers_ = nullptr, *refusal_ = nullptr;
};

} // namespace retractor
