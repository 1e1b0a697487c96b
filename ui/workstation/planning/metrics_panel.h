#pragma once
// The panel on the right with the numbers of the planned field, or the request before planning.

#include "ui/workstation/planning/session_model.h"

#include <QScrollArea>

#include <cstddef>
#include <functional>
#include <optional>

namespace retractor::ui {

class MetricsPanel : public QScrollArea {
public:
    explicit MetricsPanel(QWidget* parent = nullptr);

    /// Shows the selected approach; empty without a model or a selection.
    void show_model(const SessionModel* model);

    /// The user puts a planned approach into the comparison, or takes it out. Called later than the click, when the
    /// approaches may be others. @param id SessionModel::id()
    std::function<void(std::size_t id, bool is_compared)> on_compare;

private:
    /// What is shown: the id of an approach, or the comparison. Something else begins at its top.
    std::optional<std::size_t> shown_approach_ {};
    bool comparison_shown_ = false;
    bool technical_shown_ = false; ///< the numbers of the computation are open
};

} // namespace retractor::ui
