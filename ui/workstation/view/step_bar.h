#pragma once
// The caption under the picture in a conference or a tour: the number of the step, and buttons for the mouse.

#include "planner/decision/presentation.h"

#include <QWidget>

#include <functional>

class QLabel;
class QPushButton;

namespace retractor::ui {

class StepBar : public QWidget {
public:
    explicit StepBar(QWidget* parent = nullptr);

    /// The type is large, for a room, or small; then nothing can be saved.
    void set_large(bool large);
    /// @param number of the step, from 1
    void show_step(const planner::PresentationStep& step, std::size_t number, std::size_t count);
    /// A line under the text: what is being saved, or what went wrong; empty: none.
    void show_note(const QString& note);
    QString title() const;
    QString note() const;
    std::size_t number() const { return number_of_step_; }
    std::size_t count() const { return count_of_steps_; }
    QString text() const;

    // Set by the owner.
    std::function<void(int)> on_step; ///< +1 or -1
    std::function<void()> on_end, on_movie, on_report;

private:
    std::size_t number_of_step_ = 0, count_of_steps_ = 0;
    QLabel *title_ = nullptr, *text_ = nullptr, *number_ = nullptr, *note_ = nullptr;
    QPushButton *back_ = nullptr, *next_ = nullptr, *movie_ = nullptr, *report_ = nullptr, *end_ = nullptr;
};

} // namespace retractor::ui
