#include "ui/workstation/help/manual_window.h"

#include "ui/workstation/language/language.h"

#include <QShortcut>
#include <QTextBlock>
#include <QTextBrowser>
#include <QTextCursor>
#include <QTextDocument>
#include <QUrl>
#include <QVBoxLayout>
#include <QWidget>

#include <system_error>

namespace retractor::ui {

namespace {

    constexpr int kWidthPx = 900, kHeightPx = 720;

    /// Scrolls to the block that is this heading.
    void scroll_to(QTextBrowser& browser, const QString& heading)
    {
        for (QTextBlock block = browser.document()->begin(); block.isValid(); block = block.next())
            if (block.blockFormat().headingLevel() > 0 && block.text().compare(heading, Qt::CaseInsensitive) == 0) {
                browser.moveCursor(QTextCursor::End); // so that the heading comes to the top
                browser.setTextCursor(QTextCursor(block));
                return;
            }
    }

} // namespace

std::optional<std::filesystem::path> manual_folder(const std::filesystem::path& program_folder)
{
    constexpr const char* kPlaces[]
        = { "../share/doc/retractor/docs/user", "../../docs/user", "../../../docs/user", "../../../../docs/user" };
    for (const char* place : kPlaces) {
        std::error_code code;
        const std::filesystem::path folder = program_folder / place;
        if (std::filesystem::exists(folder / "workstation.md", code))
            return std::filesystem::weakly_canonical(folder, code);
    }
    return std::nullopt;
}

QWidget* show_manual(const std::filesystem::path& folder, const QString& page, const QString& heading, QWidget* parent)
{
    auto* window = new QWidget(parent, Qt::Window);
    window->setAttribute(Qt::WA_DeleteOnClose);
    window->setObjectName("manual");
    window->setWindowTitle(translated("Retractor: manual"));
    window->resize(kWidthPx, kHeightPx);
    auto* column = new QVBoxLayout(window);
    column->setContentsMargins(0, 0, 0, 0);
    auto* browser = new QTextBrowser;
    browser->setOpenExternalLinks(true);
    browser->setStyleSheet("QTextBrowser { background: white; color: black; padding: 16px; }");
    column->addWidget(browser);
    browser->setSource(QUrl::fromLocalFile(QString::fromStdString((folder / page.toStdString()).string())));
    auto* close = new QShortcut(QKeySequence(Qt::Key_Escape), window);
    QObject::connect(close, &QShortcut::activated, window, &QWidget::close);
    window->show();
    if (!heading.isEmpty())
        scroll_to(*browser, heading);
    return window;
}

} // namespace retractor::ui
