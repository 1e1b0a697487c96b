#pragma once
// The user's manual in a window, opened at a heading. The pages are the Markdown files of docs/user, which are
// installed with the program.

#include <QString>

#include <filesystem>
#include <optional>

class QWidget;

namespace retractor::ui {

/// The folder of the manual's pages: beside the installed program, or in the source tree above it; nothing: there is
/// none.
std::optional<std::filesystem::path> manual_folder(const std::filesystem::path& program_folder);

/// Shows a page of the manual in a window of its own; links lead to the other pages.
/// @param page file name, such as "workstation.md"
/// @param heading the page is scrolled to it; empty: to its begin
/// @returns the window, which deletes itself when it is closed
QWidget* show_manual(
    const std::filesystem::path& folder, const QString& page, const QString& heading, QWidget* parent = nullptr);

} // namespace retractor::ui
