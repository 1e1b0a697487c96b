#include "ui/workstation/conference/conference_bar.h"

#include "ui/workstation/view/controls.h"

#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>

namespace retractor::ui {

ConferenceBar::ConferenceBar(QWidget* parent)
    : QWidget(parent)
{
    setObjectName("conference");
    auto* row = new QHBoxLayout(this);
    row->setContentsMargins(24, 12, 24, 16);
    row->setSpacing(16);
    auto* words = new QVBoxLayout;
    words->setSpacing(4);
    title_ = plain_label("font-size: 26px; font-weight: bold; color: white;");
    text_ = plain_label("font-size: 20px; color: #d7dde2;");
    words->addWidget(title_);
    words->addWidget(text_);
    note_ = plain_label("font-size: 16px; color: #ffd27f;");
    note_->setObjectName("note");
    note_->hide();
    words->addWidget(note_);
    row->addLayout(words, 1);
    number_ = plain_label("font-size: 18px; color: #a4adb5;");
    number_->setWordWrap(false);
    row->addWidget(number_);
    back_ = unfocused(new QPushButton("Back"), "The step before (Left, Page Up)");
    next_ = unfocused(new QPushButton("Next"), "The next step (Right, Page Down, Space)");
    auto* movie = unfocused(new QPushButton("Movie…"), "Save a movie of the plans (Ctrl+M)");
    auto* report = unfocused(new QPushButton("Report…"), "Save the report (Ctrl+R)");
    auto* end = unfocused(new QPushButton("End"), "Back to planning (Esc)");
    for (QPushButton* button : { back_, next_, movie, report, end }) {
        button->setStyleSheet("font-size: 18px; padding: 8px 16px;");
        row->addWidget(button);
    }
    connect(back_, &QPushButton::clicked, this, [this] { on_step(-1); });
    connect(next_, &QPushButton::clicked, this, [this] { on_step(1); });
    connect(movie, &QPushButton::clicked, this, [this] { on_movie(); });
    connect(report, &QPushButton::clicked, this, [this] { on_report(); });
    connect(end, &QPushButton::clicked, this, [this] { on_end(); });
}

void ConferenceBar::show_step(const planner::PresentationStep& step, std::size_t number, std::size_t count)
{
    number_of_step_ = number;
    count_of_steps_ = count;
    title_->setText(QString::fromStdString(step.title));
    text_->setText(QString::fromStdString(step.text));
    number_->setText(QString("%1 / %2").arg(number).arg(count));
    back_->setEnabled(number > 1);
    next_->setEnabled(number < count);
}

void ConferenceBar::show_note(const QString& note)
{
    note_->setText(note);
    note_->setVisible(!note.isEmpty());
}

QString ConferenceBar::title() const { return title_->text(); }

QString ConferenceBar::text() const { return text_->text(); }

} // namespace retractor::ui
