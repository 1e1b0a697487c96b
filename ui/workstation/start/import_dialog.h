#pragma once
// Imports a study: shows its series, asks where the labels come from and where the case goes, has both read on its own
// thread, and shows what the import has to say.

#include "mesh/base/job.h"
#include "mesh/base/serial_executor.h"
#include "ui/workstation/start/study.h"

#include <QDialog>
#include <QElapsedTimer>
#include <QTimer>

#include <filesystem>
#include <functional>
#include <memory>

class QCheckBox;
class QComboBox;
class QLabel;
class QLineEdit;
class QListWidget;
class QPlainTextEdit;
class QProgressBar;
class QPushButton;
class QStackedWidget;

namespace retractor::planner {
struct ImportRequest;
}

namespace retractor::ui {

class ImportDialog : public QDialog {
public:
    explicit ImportDialog(QWidget* parent);

    /// Looks through a folder, an archive or a file.
    void set_study(const std::filesystem::path& path);
    void add_labels(const std::filesystem::path& path);
    void set_case_folder(const std::filesystem::path& folder);
    /// Reads the chosen series and the labels, and writes the case.
    void import();
    bool idle() const { return working_ == 0; }
    /// Why the last work failed; empty: it did not.
    QString failure() const;

    /// Called with the written case file when the user asks to open it.
    std::function<void(const std::filesystem::path&)> on_imported;

protected:
    void reject() override; ///< cancels work, or closes

private:
    QWidget* make_choices();
    QWidget* make_summary();
    QWidget* make_study_row();
    QWidget* make_labels();
    void ask_for_folder();
    void ask_for_file();
    void show_study();
    void show_imported(const std::filesystem::path& case_file, const QString& text);
    planner::ImportRequest request() const;
    /// Runs `task` on the executor. What it returns runs in the window's thread, unless the dialog was cancelled.
    void work(const QString& what, std::function<std::function<void()>(const Job&)> task);
    void show_progress();
    void show_failure(const QString& text);
    void show_what_applies();

    Study study_;
    std::filesystem::path case_file_;
    QString path_looked_at_; ///< the path of the last study that was asked for
    QString work_text_;
    QElapsedTimer step_time_;
    QString step_; ///< for which step_time_ runs
    int working_ = 0;
    bool cancelling_ = false;
    bool folder_chosen_ = false; ///< the user has named the case's folder

    QStackedWidget* pages_ = nullptr;
    QLineEdit *path_ = nullptr, *case_folder_ = nullptr;
    QListWidget *images_ = nullptr, *labels_ = nullptr;
    QCheckBox* find_labels_ = nullptr;
    QCheckBox* insist_ = nullptr; ///< on labels that do not fit the CT
    QComboBox* preset_ = nullptr;
    QLabel *failure_ = nullptr, *work_ = nullptr;
    QProgressBar* progress_ = nullptr;
    QPushButton *import_ = nullptr, *cancel_ = nullptr, *open_ = nullptr;
    QPlainTextEdit* findings_ = nullptr;
    QTimer timer_;
    SerialExecutor executor_; ///< declared last: its tasks use the other members
};

/// The time that a step of work has left, in words; empty where too little of it is done to tell.
QString time_left(double seconds_so_far, double fraction);

} // namespace retractor::ui
