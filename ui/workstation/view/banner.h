#pragma once
// A line over the picture that stays until its cause is gone.

#include <QWidget>

#include <functional>

class QLabel;
class QPushButton;

namespace retractor::ui {

class Banner : public QWidget {
public:
    /// Hidden until it says something. @param colour of the background, as in a style sheet
    explicit Banner(const QString& colour);

    /// Empty text: the cause is gone.
    void say(const QString& text, const QString& button = {});
    std::function<void()> on_button;

private:
    QLabel* text_ = nullptr;
    QPushButton* button_ = nullptr;
};

} // namespace retractor::ui
