#pragma once
// The cases that were opened last on this computer, with a small picture of each. They are kept in the user's settings
// and cache, and hold no patient's name or id.

#include <QDateTime>
#include <QImage>
#include <QString>

#include <filesystem>
#include <vector>

namespace retractor::ui {

struct RecentCase {
    std::filesystem::path file; ///< the case file
    QDateTime opened;
    QImage picture; ///< null: none was kept
};

/// The newest first. Files that are gone are left out.
std::vector<RecentCase> recent_cases();

/// Puts a case at the front of the list.
void remember_case(const std::filesystem::path& file);

/// Keeps a small picture of a case. A picture that cannot be written is missed by nobody.
void keep_case_picture(const std::filesystem::path& file, const QImage& picture);

} // namespace retractor::ui
