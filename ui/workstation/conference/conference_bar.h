#pragma once
// The caption under the picture in a conference: large type, the number of the step, and buttons for the mouse.

#include "planner/decision/presentation.h"

#include <QWidget>

#include <functional>

class QLabel;
class QPushButton;

namespace retractor::ui {

class ConferenceBar : public QWidget {
public:
    explicit ConferenceBar(QWidget* parent = nullptr);

    /// @param number of the step, from 1
    void show_step(const PresentationStep& step, std::size_t number, std::size_t count);
    QString title() const;
    QString text() const;

    // Set by the owner.
    std::function<void(int)> on_step; ///< +1 or -1
    std::function<void()> on_end;

private:
    QLabel *title_ = nullptr, *text_ = nullptr, *number_ = nullptr;
    QPushButton *back_ = nullptr, *next_ = nullptr;
};

} // namespace retractor::ui
