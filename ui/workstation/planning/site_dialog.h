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
    /// @param met whether the place lies in the label, and not beside it
    SiteDialog(const planner::TargetSpec& proposed, bool met, QWidget* parent);

    /// The chosen site, or the whole label.
    planner::TargetSpec target() const;

private:
    planner::TargetSpec proposed_;
    QComboBox* site_ = nullptr;
    QDoubleSpinBox* radius_ = nullptr;
};

} // namespace retractor::ui
