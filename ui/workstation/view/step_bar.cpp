#include "ui/workstation/view/step_bar.h"

#include "ui/workstation/language/language.h"
#include "ui/workstation/view/controls.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>

namespace retractor::ui {

StepBar::StepBar(QWidget* parent)
    : QWidget(parent)
{
    auto* row = new QHBoxLayout(this);
    row->setContentsMargins(24, 12, 24, 16);
    row->setSpacing(16);
    auto* words = new QVBoxLayout;
    words->setSpacing(4);
    title_ = plain_label();
    text_ = plain_label();
    words->addWidget(title_);
    words->addWidget(text_);
    note_ = plain_label("font-size: 16px; color: #ffd27f;");
    note_->setObjectName("note");
    note_->hide();
    words->addWidget(note_);
    row->addLayout(words, 1);
    number_ = plain_label();
    number_->setWordWrap(false);
    row->addWidget(number_);
    back_ = unfocused(new QPushButton("Back"));
    next_ = unfocused(new QPushButton("Next"));
    movie_ = unfocused(new QPushButton("Movie…"), "Save a movie of the plans (Ctrl+M)");
    report_ = unfocused(new QPushButton("Report…"), "Save the report (Ctrl+R)");
    end_ = unfocused(new QPushButton("End"));
    for (QPushButton* button : { back_, next_, movie_, report_, end_ })
        row->addWidget(button);
    set_large(true);
    connect(back_, &QPushButton::clicked, this, [this] { on_step(-1); });
    connect(next_, &QPushButton::clicked, this, [this] { on_step(1); });
    connect(movie_, &QPushButton::clicked, this, [this] { on_movie(); });
    connect(report_, &QPushButton::clicked, this, [this] { on_report(); });
    connect(end_, &QPushButton::clicked, this, [this] { on_end(); });
}

void StepBar::set_large(bool large)
{
    title_->setStyleSheet(QString("font-size: %1px; font-weight: bold; color: white;").arg(large ? 26 : 16));
    text_->setStyleSheet(QString("font-size: %1px; color: #d7dde2;").arg(large ? 20 : 14));
    number_->setStyleSheet(QString("font-size: %1px; color: #a4adb5;").arg(large ? 18 : 14));
    for (QPushButton* button : { back_, next_, movie_, report_, end_ })
        button->setStyleSheet(large ? "font-size: 18px; padding: 8px 16px;" : "");
    const auto keys
        = [large](const QString& text, const QString& with) { return translated(large ? text + with : text); };
    back_->setToolTip(keys("The step before", " (Left, Page Up)"));
    next_->setToolTip(keys("The next step", " (Right, Page Down, Space)"));
    end_->setToolTip(keys(large ? "Back to planning" : "End the tour", " (Esc)"));
    movie_->setVisible(large);
    report_->setVisible(large);
}

void StepBar::show_step(const planner::PresentationStep& step, std::size_t number, std::size_t count)
{
    number_of_step_ = number;
    count_of_steps_ = count;
    title_->setText(translated(step.title));
    text_->setText(translated(step.text));
    number_->setText(QString("%1 / %2").arg(number).arg(count));
    back_->setEnabled(number > 1);
    next_->setEnabled(number < count);
}

void StepBar::show_note(const QString& note)
{
    note_->setText(note);
    note_->setVisible(!note.isEmpty());
}

QString StepBar::title() const { return title_->text(); }

QString StepBar::note() const { return note_->text(); }

QString StepBar::text() const { return text_->text(); }

} // namespace retractor::ui
