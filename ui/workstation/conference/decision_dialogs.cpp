#include "ui/workstation/conference/decision_dialogs.h"

#include "mesh/base/text_format.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/view/controls.h"

#include <QButtonGroup>
#include <QDialogButtonBox>
#include <QFormLayout>
#include <QGridLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPlainTextEdit>
#include <QPushButton>
#include <QRadioButton>
#include <QVBoxLayout>

namespace retractor::ui {

namespace {

    constexpr int kWidthPx = 560;

    QPushButton* add_buttons(QDialog& dialog, QVBoxLayout& column, const QString& accept)
    {
        auto* buttons = new QDialogButtonBox(QDialogButtonBox::Cancel);
        QPushButton* button = buttons->addButton(accept, QDialogButtonBox::AcceptRole);
        button->setDefault(true);
        column.addWidget(buttons);
        QObject::connect(buttons, &QDialogButtonBox::accepted, &dialog, &QDialog::accept);
        QObject::connect(buttons, &QDialogButtonBox::rejected, &dialog, &QDialog::reject);
        return button;
    }

    std::string trimmed(const QString& text) { return text.trimmed().toStdString(); }

} // namespace

ChoiceDialog::ChoiceDialog(const std::string& approach, const std::string& plan, const std::string& holding,
    const std::string& by, QWidget* parent)
    : QDialog(parent)
{
    setWindowTitle("Choose this approach");
    setMinimumWidth(kWidthPx);
    auto* column = new QVBoxLayout(this);
    auto* head = plain_label("font-size: 16px; font-weight: bold;");
    head->setText(QString::fromStdString(approach));
    column->addWidget(head);
    auto* known = plain_label();
    known->setText(QString::fromStdString(plan.empty() ? "It is not planned." : plan));
    column->addWidget(known);
    if (!holding.empty()) {
        auto* before = plain_label();
        before->setText("So far: " + QString::fromStdString(holding));
        column->addWidget(before);
    }
    auto* form = new QFormLayout;
    by_ = new QLineEdit(QString::fromStdString(by));
    by_->setObjectName("by");
    by_->setPlaceholderText("person or team");
    why_ = new QPlainTextEdit;
    why_->setObjectName("why");
    why_->setTabChangesFocus(true);
    why_->setFixedHeight(90);
    form->addRow("Chosen by", by_);
    form->addRow("Because", why_);
    column->addLayout(form);
    accept_ = add_buttons(*this, *column, "Choose");
    const auto check = [this] { accept_->setEnabled(!this->by().empty() && !this->why().empty()); };
    connect(by_, &QLineEdit::textChanged, this, check);
    connect(why_, &QPlainTextEdit::textChanged, this, check);
    check();
    translate_texts(*this);
}

std::string ChoiceDialog::by() const { return trimmed(by_->text()); }

std::string ChoiceDialog::why() const { return trimmed(why_->toPlainText()); }

AnswersDialog::AnswersDialog(const std::string& by, QWidget* parent)
    : QDialog(parent)
{
    setWindowTitle("Six questions about the planned field");
    setMinimumWidth(kWidthPx);
    auto* column = new QVBoxLayout(this);
    auto* form = new QFormLayout;
    by_ = new QLineEdit(QString::fromStdString(by));
    by_->setObjectName("by");
    by_->setPlaceholderText("person");
    form->addRow("Answered by", by_);
    column->addLayout(form);
    auto* grid = new QGridLayout;
    grid->setHorizontalSpacing(12);
    grid->setVerticalSpacing(8);
    auto* scale = plain_label();
    scale->setText("1: I disagree … 5: I agree");
    grid->addWidget(scale, 0, 0);
    for (std::size_t q = 0; q < planner::kQuestions.size(); ++q) {
        const int row = static_cast<int>(q) + 1;
        auto* sentence = plain_label();
        sentence->setText(planner::kQuestions.at(q).sentence);
        grid->addWidget(sentence, row, 0);
        points_.at(q) = new QButtonGroup(this);
        for (int points = planner::kLeastPoints; points <= planner::kMostPoints; ++points) {
            auto* button = new QRadioButton(QString::number(points));
            button->setObjectName(QString("%1%2").arg(planner::kQuestions.at(q).key).arg(points));
            points_.at(q)->addButton(button, points);
            grid->addWidget(button, row, points);
        }
        connect(points_.at(q), &QButtonGroup::idClicked, this, [this] { show_whether_complete(); });
    }
    grid->setColumnStretch(0, 1);
    column->addLayout(grid);
    note_ = new QLineEdit;
    note_->setObjectName("note");
    note_->setPlaceholderText("a note, if you like");
    column->addWidget(note_);
    accept_ = add_buttons(*this, *column, "Keep the answers");
    connect(by_, &QLineEdit::textChanged, this, [this] { show_whether_complete(); });
    show_whether_complete();
    translate_texts(*this);
}

void AnswersDialog::show_whether_complete()
{
    bool complete = !trimmed(by_->text()).empty();
    for (const QButtonGroup* group : points_)
        complete = complete && group->checkedId() >= planner::kLeastPoints;
    accept_->setEnabled(complete);
}

planner::Answers AnswersDialog::answers() const
{
    planner::Answers answers;
    answers.by = trimmed(by_->text());
    answers.note = trimmed(note_->text());
    for (std::size_t q = 0; q < planner::kQuestions.size(); ++q)
        answers.points.at(q) = points_.at(q)->checkedId();
    return answers;
}

SummaryDialog::SummaryDialog(
    const std::vector<std::vector<planner::Answers>>& cases, const QString& remarks, QWidget* parent)
    : QDialog(parent)
{
    setObjectName("summary");
    setWindowTitle("Answers over cases");
    setMinimumWidth(kWidthPx);
    auto* column = new QVBoxLayout(this);
    auto* head = plain_label();
    head->setText(QString("%1 %2. Of several answers of one person to one case the last one counts.")
                      .arg(cases.size())
                      .arg(cases.size() == 1 ? "case" : "cases"));
    column->addWidget(head);
    const QStringList captions { "Question", "Answers", "Mean", "Range", "1", "2", "3", "4", "5" };
    auto* grid = new QGridLayout;
    grid->setHorizontalSpacing(16);
    grid->setVerticalSpacing(8);
    for (int n = 0; n < captions.size(); ++n)
        grid->addWidget(new QLabel("<b>" + translated(captions.at(n)) + "</b>"), 0, n);
    const auto summary = planner::summary_of(cases);
    for (std::size_t q = 0; q < summary.size(); ++q) {
        const planner::QuestionSummary& one = summary.at(q);
        const int row = static_cast<int>(q) + 1;
        auto* question = new QLabel(planner::kQuestions.at(q).title);
        question->setToolTip(planner::kQuestions.at(q).sentence);
        QStringList cells { QString::number(one.answers), one.answers > 0 ? QString::number(one.mean, 'f', 1) : "-",
            one.answers > 0 ? QString("%1 to %2").arg(*one.least).arg(*one.most) : "-" };
        for (const int count : one.count)
            cells += QString::number(count);
        grid->addWidget(question, row, 0);
        for (int n = 0; n < cells.size(); ++n) {
            auto* cell = new QLabel(cells.at(n));
            cell->setObjectName(QString("%1-%2").arg(planner::kQuestions.at(q).key).arg(n));
            grid->addWidget(cell, row, n + 1);
        }
    }
    grid->setColumnStretch(0, 1);
    column->addLayout(grid);
    if (!remarks.isEmpty()) {
        auto* more = plain_label("color: #f0a35e;");
        more->setText(remarks);
        column->addWidget(more);
    }
    auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close);
    column->addWidget(buttons);
    connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
    translate_texts(*this);
}

std::string answers_text(const planner::Decisions& decisions)
{
    const auto summary = planner::summary_of({ decisions.answers });
    if (summary.front().answers == 0)
        return {};
    std::string text = std::to_string(summary.front().answers)
        + (summary.front().answers == 1 ? " person answered: " : " persons answered, on average: ");
    for (std::size_t q = 0; q < planner::kQuestions.size(); ++q)
        text += (q == 0 ? "" : ", ") + std::string(planner::kQuestions.at(q).title) + " "
            + formatted("%.1f", summary.at(q).mean);
    return text + ".";
}

} // namespace retractor::ui
