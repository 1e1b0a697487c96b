#pragma once
// The numbers on the right: of the planned field, or what is asked for when it is not planned yet.

#include "ui/workstation/planning/session_model.h"

#include <QScrollArea>

namespace retractor::ui {

class MetricsPanel : public QScrollArea {
public:
    explicit MetricsPanel(QWidget* parent = nullptr);

    /// Shows the selected approach; empty without a model or a selection.
    void show_model(const SessionModel* model);
};

} // namespace retractor::ui
