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
    window.move(std::clamp(window.x(), available.left(), available.right() + 1 - window.width()),
        std::clamp(window.y(), available.top(), available.bottom() + 1 - window.height()));
}

void keep_place(const QWidget& window, const QString& name)
{
    settings().setValue("place/" + name, window.saveGeometry());
}

} // namespace retractor::ui
