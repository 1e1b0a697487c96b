#pragma once
// Asks what the surgeon does at a place of an organ, and how far the site reaches.

#include "planner/case/approach.h"

#include <QDialog>

class QComboBox;
class QDoubleSpinBox;

namespace retractor::ui {

class SiteDialog : public QDialog {
public:
    /// @param proposed label, place and radius; see planner::site_at()
    SiteDialog(const planner::TargetSpec& proposed, QWidget* parent);

    /// The chosen site, or the whole label.
    planner::TargetSpec target() const;

private:
    planner::TargetSpec proposed_;
    QComboBox* site_ = nullptr;
    QDoubleSpinBox* radius_ = nullptr;
};

} // namespace retractor::ui
