#include "ui/workstation/conference/notes_window.h"

#include "ui/workstation/language/language.h"
#include "ui/workstation/view/controls.h"
#include "ui/workstation/view/theme.h"

#include <QCloseEvent>
#include <QGuiApplication>
#include <QKeyEvent>
#include <QLabel>
#include <QPlainTextEdit>
#include <QScreen>
#include <QVBoxLayout>

namespace retractor::ui {

NotesWindow::NotesWindow(QWidget* parent)
    : QWidget(parent, Qt::Window)
{
    setWindowTitle("Notes of the conference");
    resize(640, 520);
    auto* column = new QVBoxLayout(this);
    column->setContentsMargins(24, 16, 24, 16);
    column->setSpacing(8);
    clock_ = plain_label(QString(kFaint) + " font-size: 18px;");
    title_ = plain_label("font-size: 22px; font-weight: bold; color: white;");
    text_ = plain_label("font-size: 16px; color: #d7dde2;");
    note_ = new QPlainTextEdit;
    note_->setObjectName("note");
    note_->installEventFilter(this);
    note_->setPlaceholderText("Notes for this step, kept with the case");
    note_->setStyleSheet("font-size: 18px;");
    next_ = plain_label(QString(kFaint) + " font-size: 16px;");
    column->addWidget(clock_);
    column->addWidget(title_);
    column->addWidget(text_);
    column->addWidget(note_, 1);
    column->addWidget(next_);
    constexpr int kTickMs = 1000;
    tick_.setInterval(kTickMs);
    connect(&tick_, &QTimer::timeout, this, [this] {
        const qint64 seconds = since_.elapsed() / kTickMs;
        clock_->setText(QString("%1:%2").arg(seconds / 60).arg(seconds % 60, 2, 10, QChar('0')));
    });
    translate_texts(*this);
}

void NotesWindow::start_clock()
{
    since_.start();
    clock_->setText("0:00");
    tick_.start();
}

void NotesWindow::open(bool writable)
{
    note_->setReadOnly(!writable);
    const QList<QScreen*> screens = QGuiApplication::screens();
    for (QScreen* screen : screens)
        if (screens.size() > 1 && screen != parentWidget()->screen())
            move(screen->availableGeometry().topLeft());
    show();
}

void NotesWindow::show_step(const QString& title, const QString& text, const QString& next, const QString& note)
{
    if (title == step_ && note == kept_) { // what is being written stays
        text_->setText(translated(text));
        return;
    }
    keep_note();
    step_ = title;
    kept_ = note;
    title_->setText(translated(title));
    text_->setText(translated(text));
    next_->setText(translated(next.isEmpty() ? "This is the last step." : "Next: " + translated(next)));
    note_->setPlainText(note);
}

void NotesWindow::keep_note()
{
    const QString written = note();
    if (step_.isEmpty() || written == kept_)
        return;
    kept_ = written;
    on_note(step_, written);
}

QString NotesWindow::note() const { return note_->toPlainText().trimmed(); }

QString NotesWindow::next() const { return next_->text(); }

/// Presenters for slides send these keys; letters and arrows belong to the notes.
bool NotesWindow::step_by_key(const QKeyEvent& event) const
{
    if (event.key() == Qt::Key_Escape) {
        on_end();
        return true;
    }
    if (event.key() != Qt::Key_PageDown && event.key() != Qt::Key_PageUp)
        return false;
    on_step(event.key() == Qt::Key_PageDown ? 1 : -1);
    return true;
}

bool NotesWindow::eventFilter(QObject* watched, QEvent* event)
{
    return (event->type() == QEvent::KeyPress && step_by_key(*static_cast<QKeyEvent*>(event)))
        || QWidget::eventFilter(watched, event);
}

void NotesWindow::keyPressEvent(QKeyEvent* event)
{
    if (!step_by_key(*event))
        QWidget::keyPressEvent(event);
}

void NotesWindow::closeEvent(QCloseEvent* event)
{
    keep_note();
    step_.clear();
    event->accept();
    if (on_close)
        on_close();
}

} // namespace retractor::ui
