#pragma once
// The page that the window shows before a case is open: what one can begin with, and the cases opened last.

#include "ui/workstation/start/recent_cases.h"

#include <QWidget>

#include <functional>
#include <optional>
#include <string>
#include <vector>

class QLabel;
class QListWidget;
class QProgressBar;
class QPushButton;

namespace retractor::ui {

class StartPage : public QWidget {
public:
    explicit StartPage(QWidget* parent = nullptr);

    void show_recent(const std::vector<RecentCase>& cases);
    /// Shows work that is awaited, and disables the page meanwhile; an empty text: none.
    /// @param fraction of the step, 0 to 1; nothing: not known, and the work cannot be cancelled
    void show_work(const QString& text, std::optional<double> fraction = std::nullopt);
    /// Shows why something did not work; empty: nothing.
    void show_failure(const QString& text);

    // Set by the owner.
    std::function<void()> on_import, on_open, on_demo_patient, on_tour, on_trainer, on_cancel;
    std::function<void(const std::filesystem::path&)> on_recent;

private:
    QWidget* page_ = nullptr;
    QListWidget* recent_ = nullptr;
    QLabel *no_recent_ = nullptr, *work_ = nullptr, *failure_ = nullptr;
    QProgressBar* progress_ = nullptr;
    QPushButton* cancel_ = nullptr;
    std::vector<RecentCase> cases_;
};

} // namespace retractor::ui
