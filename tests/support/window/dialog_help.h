#pragma once
// Answers to dialogs that a window opens and waits for.

#include <gtest/gtest.h>

#include <QApplication>
#include <QDialog>
#include <QLineEdit>
#include <QPushButton>
#include <QTest>
#include <QTimer>

#include <filesystem>
#include <functional>
#include <utility>

namespace retractor::test_support {

/// Fills in the dialog that opens next.
inline void fill_next_dialog(QObject& window, std::function<void(QDialog&)> fill)
{
    QTimer::singleShot(0, &window, [fill = std::move(fill)] {
        auto* dialog = qobject_cast<QDialog*>(QApplication::activeModalWidget());
        ASSERT_NE(dialog, nullptr);
        fill(*dialog);
    });
}

/// Names the file in the dialog that opens next.
inline void name_next_file(QObject& window, const std::filesystem::path& file)
{
    fill_next_dialog(window, [file](QDialog& dialog) {
        auto* name = dialog.findChild<QLineEdit*>("fileNameEdit");
        ASSERT_NE(name, nullptr);
        name->setText(QString::fromStdString(file.string()));
        QTest::keyClick(name, Qt::Key_Return);
    });
}

/// @return null: there is no such button
inline QPushButton* button_of(QWidget& widget, const QString& text)
{
    for (QPushButton* button : widget.findChildren<QPushButton*>())
        if (button->text() == text)
            return button;
    return nullptr;
}

} // namespace retractor::test_support
