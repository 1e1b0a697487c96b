#pragma once
// What only the presenter sees, on a second screen where there is one: the present step, the next one, the time since
// the conference began, and notes for each step.

#include <QElapsedTimer>
#include <QTimer>
#include <QWidget>

#include <functional>

class QLabel;
class QPlainTextEdit;

namespace retractor::ui {

class NotesWindow : public QWidget {
public:
    explicit NotesWindow(QWidget* parent);

    /// The conference begins now.
    void start_clock();
    /// Shows the window on a second screen where there is one. @param writable notes can be changed
    void open(bool writable);
    /// @param next title of the next step; empty: this is the last one
    void show_step(const QString& title, const QString& text, const QString& next, const QString& note);
    /// Gives the note that is being written to its step.
    void keep_note();
    QString note() const;
    QString next() const;

    // Set by the owner.
    std::function<void(const QString& step, const QString& text)> on_note; ///< a note was changed
    std::function<void(int)> on_step; ///< +1 or -1
    std::function<void()> on_end, on_close; ///< Esc ends the conference

protected:
    /// Page Down and Page Up go to another step and Esc ends the conference, also while notes are written.
    bool eventFilter(QObject* watched, QEvent* event) override;
    void keyPressEvent(QKeyEvent* event) override;
    void closeEvent(QCloseEvent* event) override;

private:
    bool step_by_key(const QKeyEvent& event) const;

    QString step_, kept_; ///< title of the shown step, and its note as the owner knows it
    QLabel *title_ = nullptr, *text_ = nullptr, *next_ = nullptr, *clock_ = nullptr;
    QPlainTextEdit* note_ = nullptr;
    QElapsedTimer since_;
    QTimer tick_;
};

} // namespace retractor::ui
