#pragma once
// Where a window lies on the screen, kept from one run to the next.

#include <QSize>
#include <QString>

class QWidget;

namespace retractor::ui {

/// Gives a window the place that it had when keep_place() was last called with this name, or else a size; in both cases
/// the window fits its screen.
void restore_place(QWidget& window, const QString& name, const QSize& size);
/// Keeps the window's place in the user's settings.
void keep_place(const QWidget& window, const QString& name);

} // namespace retractor::ui
