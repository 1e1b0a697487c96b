#include "ui/workstation/planning/metrics_panel.h"
#include "ui/workstation/view/theme.h"

#include "ui/workstation/planning/metric_rows.h"

#include <QGridLayout>
#include <QLabel>
#include <QScrollBar>
#include <QVBoxLayout>

namespace retractor::ui {

namespace {

    constexpr const char* kWarning = "color: #f0a35e; font-weight: bold;";

    QLabel* label(const std::string& text, const QString& style = {}, double points = 0.0, bool bold = false)
    {
        auto* made = new QLabel(QString::fromStdString(text));
        made->setTextFormat(Qt::PlainText);
        made->setWordWrap(true);
        made->setTextInteractionFlags(Qt::TextSelectableByMouse);
        made->setStyleSheet(style);
        QFont font = made->font();
        if (points > 0.0)
            font.setPointSizeF(points);
        font.setBold(bold);
        made->setFont(font);
        return made;
    }

    void add_section(QVBoxLayout& column, const MetricSection& section)
    {
        column.addSpacing(10);
        column.addWidget(label(section.title, "color: #7ab4e8;", 10.5, true));
        auto* grid = new QGridLayout;
        grid->setHorizontalSpacing(10);
        grid->setVerticalSpacing(4);
        grid->setColumnStretch(1, 1);
        for (const MetricRow& row : section.rows) {
            const int at = grid->rowCount();
            QLabel* key = label(row.key, kFaint);
            QLabel* value = label(row.value, row.warning ? kWarning : "");
            value->setAlignment(Qt::AlignRight | Qt::AlignTop);
            key->setAlignment(Qt::AlignLeft | Qt::AlignTop);
            for (QLabel* cell : { key, value })
                cell->setToolTip(QString::fromStdString(row.meaning));
            grid->addWidget(key, at, 0);
            grid->addWidget(value, at, 1);
        }
        column.addLayout(grid);
    }

    void add_headline(QVBoxLayout& column, const FieldPictures& field)
    {
        const MetricSection sight = field_rows(field.metrics).front();
        column.addWidget(label(sight.rows.at(1).value, "color: white;", 26.0, true));
        column.addWidget(label("of " + field.metrics.target + " seen", kFaint));
        if (!field.warning.empty())
            column.addWidget(label(field.warning, kWarning));
    }

    void add_planned(QVBoxLayout& column, const FieldPictures& field)
    {
        add_headline(column, field);
        for (const MetricSection& section : field_rows(field.metrics))
            add_section(column, section);
        if (field.metrics.explanation.empty())
            return;
        column.addSpacing(10);
        column.addWidget(label("Why", "color: #7ab4e8;", 10.5, true));
        column.addWidget(label(field.metrics.explanation));
    }

    std::string state_in_words(FieldStatus status)
    {
        switch (status) {
        case FieldStatus::closed:
            return "Not planned yet: press Plan to cut, open and measure.";
        case FieldStatus::waiting:
            return "Waiting to be planned.";
        case FieldStatus::planning:
            return "Being planned.";
        case FieldStatus::cancelling:
            return "Being cancelled.";
        case FieldStatus::failed:
            return "Planning failed.";
        case FieldStatus::planned:
            break;
        }
        return {};
    }

    void add_unplanned(QVBoxLayout& column, const planner::Approach& approach, const ApproachState& state)
    {
        column.addWidget(label(state_in_words(state.status), kFaint));
        if (state.failure)
            column.addWidget(label(to_string(*state.failure), kWarning));
        for (const MetricSection& section : approach_rows(approach))
            add_section(column, section);
        if (!approach.rationale.empty()) {
            column.addSpacing(10);
            column.addWidget(label("Why", "color: #7ab4e8;", 10.5, true));
            column.addWidget(label(approach.rationale));
        }
    }

} // namespace

MetricsPanel::MetricsPanel(QWidget* parent)
    : QScrollArea(parent)
{
    setWidgetResizable(true);
    setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    setAccessibleName("Numbers of the field");
    show_model(nullptr);
}

void MetricsPanel::show_model(const SessionModel* model)
{
    auto* page = new QWidget;
    page->setObjectName("page");
    page->setStyleSheet("#page { background: #1d2125; }");
    auto* column = new QVBoxLayout(page);
    column->setContentsMargins(14, 12, 14, 12);
    column->setSpacing(4);
    if (model != nullptr && model->selected()) {
        const std::size_t index = *model->selected();
        column->addWidget(label(model->approach(index).name, "color: white;", 13.0, true));
        if (model->state(index).field != nullptr)
            add_planned(*column, *model->state(index).field);
        else
            add_unplanned(*column, model->approach(index), model->state(index));
    } else if (model != nullptr) {
        column->addWidget(label(
            "The case has no approach yet. Press New for a standard approach, or Draw to draw an incision on the skin.",
            kFaint));
    }
    column->addStretch(1);
    const int scrolled = verticalScrollBar() != nullptr ? verticalScrollBar()->value() : 0;
    setWidget(page);
    verticalScrollBar()->setValue(scrolled);
}

} // namespace retractor::ui
