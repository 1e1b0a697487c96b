#pragma once
// Dark and neutral: the tissue colours of the picture are judged against it.

class QApplication;

namespace retractor::ui {

/// Style of words beside what matters.
inline constexpr const char* kFaint = "color: #a4adb5;";

void apply_theme(QApplication& application);

} // namespace retractor::ui
