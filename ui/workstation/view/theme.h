#pragma once
// The dark, neutral theme of the window: the picture's tissue colours are seen against it.

class QApplication;
class QLabel;
class QStatusBar;

namespace retractor::ui {

/// Style of minor texts.
inline constexpr const char* kFaint = "color: #a4adb5;";

void apply_theme(QApplication& application);

/// Adds the line of messages at the left of the status bar.
QLabel* add_message(QStatusBar& bar);
/// Adds the notice "Not a medical device" at the right of the status bar.
void add_notice(QStatusBar& bar);

} // namespace retractor::ui
