#pragma once
// The dark, neutral theme of the window: the picture's tissue colours are seen against it.

class QApplication;

namespace retractor::ui {

/// Style of minor texts.
inline constexpr const char* kFaint = "color: #a4adb5;";

void apply_theme(QApplication& application);

} // namespace retractor::ui
