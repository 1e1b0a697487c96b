#pragma once
// The list on the left: one approach per entry, with its state as text and as a coloured dot.

#include "ui/workstation/planning/session_model.h"

#include <QListWidget>

namespace retractor::ui {

class ApproachList : public QListWidget {
public:
    explicit ApproachList(QWidget* parent = nullptr);

    /// Shows the model's approaches and selection without emitting a signal for the selection.
    void show_model(const SessionModel& model);
};

} // namespace retractor::ui
