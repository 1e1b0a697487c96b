#include "ui/workstation/planning/metrics_panel.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/view/theme.h"

#include "mesh/base/text_format.h"
#include "planner/approach/approach_draft.h"
#include "planner/measures/comparison.h"
#include "planner/measures/ranking.h"
#include "ui/scene/scene_language.h"
#include "ui/workstation/planning/comparison_chart.h"
#include "ui/workstation/planning/metric_rows.h"

#include <QCheckBox>
#include <QGridLayout>
#include <QLabel>
#include <QScrollBar>
#include <QToolButton>
#include <QVBoxLayout>

#include <algorithm>
#include <string>
#include <vector>

namespace retractor::ui {

namespace {

    constexpr std::size_t kLettersOfABox = 32; ///< in a line of the narrowest panel
    constexpr const char* kWarning = "color: #f0a35e; font-weight: bold;";

    QLabel* label(const std::string& text, const QString& style = {}, double points = 0.0, bool bold = false)
    {
        auto* made = new QLabel(translated(text));
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
                cell->setToolTip(translated(row.meaning));
            grid->addWidget(key, at, 0);
            grid->addWidget(value, at, 1);
        }
        column.addLayout(grid);
    }

    void add_headline(QVBoxLayout& column, const FieldPictures& field)
    {
        const planner::Verdict verdict = planner::verdict_of(field.metrics);
        const LightLook look = light_look(verdict.light);
        if (field.metrics.solution.draft)
            column.addWidget(
                label("This is a draft: its force, and with it what breaks, may be half of the plan's or more "
                      "than twice. It is not saved. P makes the plan.",
                    kWarning));
        column.addWidget(label(std::string("\u25cf  ") + look.word, QString("color: %1;").arg(look.color), 12.0, true));
        std::string sentences;
        for (const std::string& sentence : verdict.sentences)
            sentences += (sentences.empty() ? "" : " ") + sentence;
        column.addWidget(label(sentences, "color: white;", 11.0));
    }

    /// Numbers that are not to be used stand where one asks for them only, under "Technical".
    void add_planned(QVBoxLayout& column, const FieldPictures& field)
    {
        add_headline(column, field);
        if (!planner::is_solved(field.metrics)) {
            column.addWidget(label("The numbers are under Technical.", kFaint));
            return;
        }
        for (const MetricSection& section : field_rows(field.metrics))
            if (!section.technical)
                add_section(column, section);
        if (field.metrics.explanation.empty())
            return;
        column.addSpacing(10);
        column.addWidget(label("Why", "color: #7ab4e8;", 10.5, true));
        column.addWidget(label(field.metrics.explanation));
    }

    /// The sections about the computation, behind a button that opens them.
    void add_technical(QVBoxLayout& column, const FieldPictures& field, bool& shown)
    {
        auto* button = new QToolButton;
        button->setText(translated("Technical"));
        button->setToolButtonStyle(Qt::ToolButtonTextBesideIcon);
        button->setArrowType(shown ? Qt::DownArrow : Qt::RightArrow);
        button->setFocusPolicy(Qt::NoFocus);
        auto* details = new QWidget;
        auto* rows = new QVBoxLayout(details);
        rows->setContentsMargins(0, 0, 0, 0);
        if (!field.warning.empty())
            rows->addWidget(label(field.warning, kWarning));
        for (const MetricSection& section : field_rows(field.metrics))
            if (section.technical || !planner::is_solved(field.metrics))
                add_section(*rows, section);
        details->setVisible(shown);
        QObject::connect(button, &QToolButton::clicked, details, [button, details, &shown] {
            shown = !shown;
            details->setVisible(shown);
            button->setArrowType(shown ? Qt::DownArrow : Qt::RightArrow);
        });
        column.addSpacing(10);
        column.addWidget(button);
        column.addWidget(details);
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

    /// "Score 53 +- 2, the highest": the place of a field among the ranked ones; empty: it is not ranked.
    std::string score_text(const std::vector<planner::RankedField>& order, std::size_t n)
    {
        const auto found = std::find_if(
            order.begin(), order.end(), [n](const planner::RankedField& ranked) { return ranked.index == n; });
        if (found == order.end())
            return {};
        std::string text = "Score " + in_words(found->score.points)
            + (found->score.bar ? " \u00b1 " + in_words(*found->score.bar) : "");
        if (found->score.factor < 1.0)
            text += ", lowered because little is seen";
        if (found == order.begin())
            text += order.size() > 1 && order[1].within_error ? ", the highest, within the error" : ", the highest";
        return text;
    }

    /// "The score weighs: target seen 3, reached by instruments 2."
    std::string weights_in_words(const planner::Weights& weights)
    {
        std::string text = "The score weighs: ";
        for (std::size_t n = 0; n < planner::kCriteria; ++n)
            text += (n == 0 ? "" : ", ") + translated(planner::criteria()[n].caption).toStdString()
                + formatted(" %g", weights.at(n));
        return text + ". Shift+W changes this.";
    }

    /// A box to tick for each planned approach, where there is a choice.
    void add_choice(QVBoxLayout& column, const SessionModel& model, const MetricsPanel& panel)
    {
        const std::vector<std::size_t> planned = model.planned(), compared = model.compared();
        if (planned.size() <= planner::kLeastCompared)
            return;
        column.addWidget(label("Side by side, two to four:", kFaint));
        for (const std::size_t index : planned) {
            const bool is_compared = std::find(compared.begin(), compared.end(), index) != compared.end();
            QStringList lines; // a box breaks no lines
            for (const std::string& line :
                in_lines(translated(planner::spoken_name(model.approach(index))).toStdString(), kLettersOfABox))
                lines += QString::fromStdString(line);
            auto* box = new QCheckBox(lines.join("\n"));
            box->setObjectName("compare-" + QString::fromStdString(model.approach(index).name));
            box->setChecked(is_compared);
            QPalette colors = box->palette(); // an empty box must show
            colors.setColor(QPalette::Base, QColor(0x4a, 0x53, 0x5c));
            for (const QPalette::ColorRole role : { QPalette::Text, QPalette::WindowText })
                colors.setColor(QPalette::Disabled, role, QColor(0xa4, 0xad, 0xb5));
            box->setPalette(colors);
            if (!model.compared_with(index, !is_compared))
                box->setToolTip(translated(QString("Two to four stand side by side.")));
            box->setEnabled(model.compared_with(index, !is_compared).has_value());
            // Later: the panel makes its boxes anew.
            QObject::connect(
                box, &QCheckBox::clicked, &panel,
                [&panel, id = model.id(index)](bool checked) {
                    if (panel.on_compare)
                        panel.on_compare(id, checked);
                },
                Qt::QueuedConnection);
            column.addWidget(box);
        }
    }

    /// The verdicts of the compared approaches, their scores, the chart that compares them, and what to think of first.
    void add_comparison(QVBoxLayout& column, const SessionModel& model)
    {
        std::vector<planner::FieldMetrics> fields;
        std::vector<planner::Candidate> candidates;
        std::vector<std::size_t> places;
        std::vector<std::string> letters;
        const std::vector<std::size_t> compared = model.compared();
        for (const std::size_t index : compared) {
            const FieldPictures& field = *model.state(index).field;
            fields.push_back(field.metrics);
            candidates.push_back({ .field = field.metrics, .divided_bones = field.divided_bones });
            places.push_back(model.place_of(index));
            letters.push_back(planner::compared_letter(places.back()));
        }
        const bool one_target = planner::have_one_target(fields);
        const std::vector<planner::RankedField> order
            = one_target ? planner::ranked(candidates, model.weights()) : std::vector<planner::RankedField>();
        for (std::size_t n = 0; n < fields.size(); ++n) {
            const planner::Verdict verdict = planner::verdict_of(fields[n]);
            const LightLook look = light_look(verdict.light);
            column.addSpacing(6);
            column.addWidget(label(letters[n] + "  " + planner::spoken_name(model.approach(compared[n])),
                QString("color: %1;").arg(compared_color(places[n]).name()), 11.0, true));
            column.addWidget(
                label(std::string("\u25cf  ") + look.word, QString("color: %1;").arg(look.color), 10.0, true));
            if (!verdict.sentences.empty())
                column.addWidget(label(verdict.sentences.front(), "color: white;"));
            if (const std::string score = score_text(order, n); !score.empty())
                column.addWidget(label(score, kFaint));
        }
        if (!order.empty()) {
            column.addSpacing(6);
            column.addWidget(label(weights_in_words(model.weights()), kFaint));
        }
        column.addSpacing(10);
        std::vector<planner::FieldMetrics> solved;
        std::vector<std::size_t> places_of_solved;
        for (std::size_t n = 0; n < fields.size(); ++n)
            if (planner::is_solved(fields[n])) {
                solved.push_back(fields[n]);
                places_of_solved.push_back(places[n]);
            } else {
                column.addWidget(label(letters[n] + ": the numbers are not to be used.", kFaint));
            }
        if (!solved.empty()) {
            auto* chart = new ComparisonChart;
            chart->show_fields(solved, places_of_solved);
            column.addWidget(chart);
            column.addWidget(label("Green: better than every other by more than both errors together.", kFaint));
        }
        if (!one_target)
            column.addWidget(label(std::string(planner::kDifferentTargets), kWarning));
        column.addSpacing(10);
        column.addWidget(label("Think of this first", "color: white;", 11.0, true));
        for (std::size_t n = 0; n < candidates.size(); ++n)
            column.addWidget(label(letters[n] + ": " + translated(planner::crisis_text(candidates[n])).toStdString(),
                QString("color: %1;").arg(compared_color(places[n]).name())));
        for (const std::string& sentence : planner::sight_order_sentences(fields, letters))
            column.addWidget(label(sentence, "color: #d7dde2;"));
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
    if (model != nullptr && model->shown_view() == ViewPreset::compare) {
        column->addWidget(label("Comparison", "color: white;", 13.0, true));
        add_choice(*column, *model, *this);
        add_comparison(*column, *model);
    } else if (model != nullptr && model->selected()) {
        const std::size_t index = *model->selected();
        column->addWidget(label(planner::spoken_name(model->approach(index)), "color: white;", 13.0, true));
        if (model->state(index).field != nullptr) {
            add_planned(*column, *model->state(index).field);
            add_technical(*column, *model->state(index).field, technical_shown_);
        } else
            add_unplanned(*column, model->approach(index), model->state(index));
    } else if (model != nullptr) {
        column->addWidget(label(
            "The case has no approach yet. Press New for a standard approach, or Draw to draw an incision on the skin.",
            kFaint));
    }
    column->addStretch(1);
    const bool compares = model != nullptr && model->shown_view() == ViewPreset::compare;
    const std::optional<std::size_t> approach
        = model != nullptr && model->selected() ? std::optional(model->id(*model->selected())) : std::nullopt;
    const bool same = comparison_shown_ == compares && (compares || shown_approach_ == approach);
    comparison_shown_ = compares;
    shown_approach_ = approach;
    const int scrolled = same ? verticalScrollBar()->value() : 0;
    const QWidget* const focused = widget() != nullptr ? widget()->focusWidget() : nullptr;
    const QString name = focused != nullptr && focused->hasFocus() ? focused->objectName() : QString();
    setWidget(page);
    verticalScrollBar()->setValue(scrolled);
    if (auto* again = name.isEmpty() ? nullptr : page->findChild<QWidget*>(name))
        again->setFocus();
}

} // namespace retractor::ui
