#include "ui/workstation/view/window_place.h"

#include <QGuiApplication>
#include <QScreen>
#include <QSettings>
#include <QWidget>

#include <algorithm>

namespace retractor::ui {

namespace {

    QSettings settings() { return QSettings("Retractor", "retractor-workstation"); }

} // namespace

void restore_place(QWidget& window, const QString& name, const QSize& size)
{
    window.resize(size);
    window.restoreGeometry(settings().value("place/" + name).toByteArray());
    const QScreen* screen = QGuiApplication::screenAt(window.geometry().center());
    if (screen == nullptr)
        screen = QGuiApplication::primaryScreen();
    if (screen == nullptr)
        return;
    const QRect available = screen->availableGeometry();
    window.resize(window.size().boundedTo(available.size()));
    // A window that is larger than its screen shows its upper left corner.
    window.move(std::max(available.left(), std::min(window.x(), available.right() + 1 - window.width())),
        std::max(available.top(), std::min(window.y(), available.bottom() + 1 - window.height())));
}

void keep_place(const QWidget& window, const QString& name)
{
    settings().setValue("place/" + name, window.saveGeometry());
}

} // namespace retractor::ui
