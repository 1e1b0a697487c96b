#include "ui/workstation/view/theme.h"

#include <QApplication>
#include <QFont>
#include <QLabel>
#include <QPalette>
#include <QStatusBar>
#include <QStyleFactory>

namespace retractor::ui {

namespace {

    constexpr const char* kSheet = R"(
QToolBar { background: #262b30; border: none; border-bottom: 1px solid #15181b; padding: 4px; spacing: 2px; }
QToolBar QToolButton { padding: 6px 5px; border-radius: 4px; color: #e4e8eb; }
QToolBar QToolButton:hover { background: #353c43; }
QToolBar QToolButton:checked { background: #2d6da8; color: white; }
QToolBar QToolButton:disabled { color: #6d757d; }
QToolBar QToolButton#qt_toolbar_ext_button { padding: 0px; min-width: 20px; background: #353c43; }
QToolBar::separator { background: #3b4249; width: 1px; margin: 4px 3px; }
QToolButton { padding: 6px 8px; border-radius: 4px; border: 1px solid #3b4249; color: #e4e8eb; }
QToolButton#narrow { padding: 6px 1px; }
QToolButton:hover { background: #353c43; }
QToolButton:checked { background: #2d6da8; color: white; }
QToolButton:disabled { color: #6d757d; }
QToolBar QToolButton { border: none; }
QStatusBar { background: #262b30; border-top: 1px solid #15181b; }
QStatusBar::item { border: none; }
QListWidget { border: none; background: #1d2125; outline: none; }
QScrollArea { border: none; background: #1d2125; }
QSplitter::handle { background: #15181b; }
QProgressBar { border: 1px solid #3b4249; border-radius: 3px; background: #1d2125; text-align: center; color: #e4e8eb; }
QProgressBar::chunk { background: #2d6da8; }
QToolTip { background: #11151a; color: #e4e8eb; border: 1px solid #3b4249; padding: 4px; }
)";

} // namespace

void apply_theme(QApplication& application)
{
    QApplication::setStyle(QStyleFactory::create("Fusion"));
    QPalette palette;
    const QColor text(0xe4, 0xe8, 0xeb);
    const QColor faint(0x6d, 0x75, 0x7d);
    palette.setColor(QPalette::Window, QColor(0x26, 0x2b, 0x30));
    palette.setColor(QPalette::Base, QColor(0x1d, 0x21, 0x25));
    palette.setColor(QPalette::AlternateBase, QColor(0x24, 0x29, 0x2e));
    palette.setColor(QPalette::Button, QColor(0x33, 0x39, 0x40));
    palette.setColor(QPalette::Highlight, QColor(0x2d, 0x6d, 0xa8));
    palette.setColor(QPalette::HighlightedText, Qt::white);
    palette.setColor(QPalette::Link, QColor(0x7a, 0xb4, 0xe8));
    for (const QPalette::ColorRole role :
        { QPalette::WindowText, QPalette::Text, QPalette::ButtonText, QPalette::ToolTipText }) {
        palette.setColor(role, text);
        palette.setColor(QPalette::Disabled, role, faint);
    }
    // The style draws disabled entries of menus twice, the second time in this colour: that of the menu hides it.
    palette.setColor(QPalette::Disabled, QPalette::Light, QColor(0x1f, 0x24, 0x28));
    QApplication::setPalette(palette);
    QFont font = QApplication::font();
    font.setPointSizeF(10.0);
    QApplication::setFont(font);
    application.setStyleSheet(kSheet);
}

QLabel* add_message(QStatusBar& bar)
{
    auto* message = new QLabel;
    message->setTextFormat(Qt::PlainText);
    message->setTextInteractionFlags(Qt::TextSelectableByMouse);
    message->setContentsMargins(8, 0, 8, 0);
    message->setWordWrap(true);
    message->setFixedHeight(2 * message->fontMetrics().lineSpacing() + 2); // the bar keeps its height
    message->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed);
    bar.addWidget(message, 1);
    return message;
}

void add_notice(QStatusBar& bar)
{
    auto* notice = new QLabel("Not a medical device");
    notice->setStyleSheet(QString(kFaint) + " padding: 0 8px;");
    bar.addPermanentWidget(notice);
}

} // namespace retractor::ui
