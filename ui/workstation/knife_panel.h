#pragma once
// The knife's settings and the list of cuts, on the right.

#include "ui/workstation/knife_worker.h"

#include <QWidget>

#include <functional>

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QLabel;
class QListWidget;
class QPushButton;

namespace retractor {

class KnifePanel : public QWidget {
public:
    explicit KnifePanel(QWidget* parent = nullptr);

    KnifeSettings settings() const;
    double tension() const; ///< strain
    void set_tension(double strain); ///< one of those offered
    /// @param news null: there is no table laid out.
    void show_news(const KnifeNews* news, double draw_ms);

    // Set by the owner; called when a button is pressed.
    std::function<void()> on_undo, on_redo, on_export, on_tension;
    std::function<void(bool wanted)> on_restore;
    /// How many cuts are to be in force: an entry of the list was activated.
    std::function<void(std::size_t)> on_go_to;

    QDoubleSpinBox& depth() { return *depth_; }
    QListWidget& list() { return *cuts_; }
    QPushButton& restore_button() { return *restore_; }
    QPushButton& discard_button() { return *discard_; }

private:
    QWidget* make_question();
    QDoubleSpinBox* depth_ = nullptr;
    QCheckBox *through_ = nullptr, *bone_ = nullptr;
    QComboBox* tension_ = nullptr;
    QListWidget* cuts_ = nullptr;
    QWidget* question_ = nullptr; ///< restore the cuts of the last time?
    QLabel* question_text_ = nullptr;
    QPushButton *restore_ = nullptr, *discard_ = nullptr;
    QPushButton *undo_ = nullptr, *redo_ = nullptr, *export_ = nullptr;
    QLabel* state_ = nullptr;
};

} // namespace retractor
