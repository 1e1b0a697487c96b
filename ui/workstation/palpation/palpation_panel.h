#pragma once
// The panel on the right of a palpation: forces and depths of the fingers, and the settings that can change meanwhile.

#include "planner/session/palpation_worker.h"

#include <QWidget>

#include <array>
#include <functional>
#include <set>
#include <vector>

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QFormLayout;
class QLabel;
class QPushButton;
class QVBoxLayout;

namespace retractor::ui {

class PalpationPanel : public QWidget {
public:
    explicit PalpationPanel(std::vector<std::string> models, QWidget* parent = nullptr);

    /// Shows the settings of a newly opened scene, before its tissue is ready.
    void begin(const planner::PalpationSetup& setup, double depth, double deepest);
    /// @param scene_notes notes about the scene; they stand before the notes about the tissue
    void show_snapshot(const planner::PalpationSnapshot& snapshot, const std::vector<std::string>& scene_notes);
    void show_frame(const planner::PalpationFrame& frame, std::size_t finger_in_hand,
        const std::array<bool, planner::kMostFingers>& out);
    void show_depth(double mm);
    /// What can be put through the wound; empty: nothing is round the tissue.
    void show_ways(const std::vector<planner::ThroughOpening>& ways);

    [[nodiscard]] planner::PalpationSetup setup() const; ///< the chosen settings
    /// The chosen template, without a place.
    [[nodiscard]] haptics::ElasticTemplate chosen_template() const;
    [[nodiscard]] bool wants_spheres() const;
    [[nodiscard]] bool wants_hands() const;
    [[nodiscard]] std::set<Label> hidden_organs() const;
    void set_edit_place(bool placed); ///< tells whether Apply has a place

    // Set by the owner.
    std::function<void(planner::palpation::Command)> on_command;
    std::function<void()> on_setup, on_view, on_template, on_place, on_apply, on_lift, on_reset, on_record;
    std::function<void(double)> on_depth;
    std::function<void(bool)> on_grip;

    // For tests and keys.
    QDoubleSpinBox& depth() { return *depth_; }
    QDoubleSpinBox& heart_rate() { return *heart_rate_; }
    QDoubleSpinBox& gain() { return *gain_; }
    QDoubleSpinBox& template_modulus() { return *modulus_; }
    QDoubleSpinBox& template_size() { return *size_[0]; }
    QComboBox& model() { return *model_; }
    QComboBox& through() { return *through_; }
    QComboBox& device(std::size_t finger) { return *rows_[finger].device; }
    QPushButton& rearm_button() { return *rearm_; }
    QPushButton& apply_button() { return *apply_; }
    QPushButton& record_button() { return *record_; }
    QCheckBox& spheres_box() { return *spheres_; }
    QCheckBox& hands_box() { return *hands_; }
    QCheckBox& grip_box() { return *grip_; }
    [[nodiscard]] QString force_text(std::size_t finger) const;
    [[nodiscard]] QString fault_text() const; ///< text of the fault; empty: the servo is armed

private:
    struct FingerRow {
        QWidget* row = nullptr;
        QLabel *name = nullptr, *force = nullptr, *depth = nullptr;
        QComboBox* device = nullptr;
    };
    QWidget* make_servo();
    QWidget* make_fingers();
    QWidget* make_tissue(const std::vector<std::string>& models);
    QWidget* make_template();
    QWidget* make_view();
    QPushButton* button(const QString& text, const QString& tip, std::function<void()> PalpationPanel::*run);
    QPushButton* button(const QString& text, const QString& tip, const std::function<void()>& run);
    void give(planner::palpation::Command command);
    QDoubleSpinBox* number(double low, double high, int decimals, double step, const QString& suffix);
    void call(const std::function<void()>& function) const;
    void show_organs(const std::vector<std::string>& organs);

    std::array<FingerRow, planner::kMostFingers> rows_;
    QLabel *through_name_ = nullptr, *servo_ = nullptr, *fault_ = nullptr, *notes_ = nullptr, *edit_state_ = nullptr;
    QPushButton *rearm_ = nullptr, *place_ = nullptr, *apply_ = nullptr, *record_ = nullptr;
    QDoubleSpinBox *depth_ = nullptr, *heart_rate_ = nullptr, *gain_ = nullptr, *modulus_ = nullptr, *ratio_ = nullptr;
    std::array<QDoubleSpinBox*, 3> size_ {};
    QComboBox *through_ = nullptr, *model_ = nullptr, *shape_ = nullptr, *role_ = nullptr;
    QCheckBox *spheres_ = nullptr, *hands_ = nullptr, *grip_ = nullptr, *changes_modulus_ = nullptr,
              *changes_ratio_ = nullptr;
    QWidget *template_ = nullptr, *organs_ = nullptr;
    QVBoxLayout* organ_rows_ = nullptr;
    std::vector<QCheckBox*> organ_boxes_;
    std::vector<std::string> organ_names_;
    planner::PalpationSetup known_;
    std::size_t edits_ = 0;
    bool placed_ = false, can_edit_ = false, quiet_ = false, unwritten_ = false;
};

} // namespace retractor::ui
