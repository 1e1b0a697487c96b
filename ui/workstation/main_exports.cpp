// What the main window saves as files of its own: pictures, movies, the report, the cut wall and the log.

#include "ui/workstation/language/language.h"
#include "ui/workstation/language/translated_page.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/view/controls.h"
#include "ui/workstation/view/picture_view.h"
#include "ui/workstation/view/png_file.h"
#include "ui/workstation/view/step_bar.h"

#include <QAction>
#include <QFileDialog>
#include <QSaveFile>
#include <QStatusBar>

#include <string>
#include <utility>

namespace retractor::ui {

namespace {

    QString with_ending(QString file, const QString& ending)
    {
        return file.isEmpty() || file.endsWith(ending, Qt::CaseInsensitive) ? file : file + ending;
    }

} // namespace

void MainWindow::save_picture(const std::filesystem::path& path) { write_png_file(path, view_->picture()); }

void MainWindow::save_screenshot(const std::filesystem::path& path)
{
    if (!start_page_shown())
        view_->picture();
    write_png_file(path, grab().toImage());
}

void MainWindow::ask_for_picture_file()
{
    const QString file = with_ending(
        QFileDialog::getSaveFileName(this, translated("Save picture"), "picture.png", translated("Picture (*.png)")),
        ".png");
    if (file.isEmpty())
        return;
    log_.hide(file.toStdString());
    try {
        save_picture(file.toStdString());
        show_message("Saved " + file);
    } catch (...) {
        show_error(with_controls(current_failure()));
    }
}

void MainWindow::ask_for_export_file()
{
    const QString file = with_ending(QFileDialog::getSaveFileName(this, translated("Export the cut wall"),
                                         "cut-wall.vtu", translated("Mesh (*.vtu)")),
        ".vtu");
    if (file.isEmpty())
        return;
    log_.hide(file.toStdString());
    knife_->run(planner::surgery::ExportWall { file.toStdString() });
}

void MainWindow::ask_for_log_file()
{
    const QString file = QFileDialog::getSaveFileName(
        this, translated("Save the log"), "retractor-log.txt", translated("Text (*.txt)"));
    if (file.isEmpty())
        return;
    log_.hide(file.toStdString());
    QSaveFile out(file); // written beside, then renamed
    const std::string text = log_text();
    if (!out.open(QIODevice::WriteOnly) || out.write(text.c_str(), static_cast<qint64>(text.size())) < 0
        || !out.commit())
        return show_error({ "the log cannot be written: " + out.errorString().toStdString(), file.toStdString() });
    show_message("Saved " + file);
}

/// Writes in the background. @param write returns false when it was cancelled
void MainWindow::run_export(const QString& file, std::function<bool(const Job&)> write)
{
    ++exports_running_;
    log_.hide(file.toStdString());
    export_executor_.post([this, file, write = std::move(write)](const Job& job) {
        std::function<void()> deliver;
        try {
            job.report("begin", 0.0);
            const QString said = write(job) ? "Saved " + file : "Not saved: cancelled";
            deliver = [this, said] { show_message(said); };
        } catch (...) {
            deliver = [this, failure = with_controls(current_failure())] { show_error(failure); };
        }
        post_back([this, deliver] {
            --exports_running_;
            show_all();
            deliver();
        });
    });
    show_all();
}

PlanningBackend::Shown MainWindow::shown_plans() const
{
    PlanningBackend::Shown shown { .planned_case = model_->planned_case(),
        .planned = {},
        .decisions = model_->decisions(),
        .language = picture_language() };
    for (const std::size_t index : model_->planned())
        shown.planned.push_back(model_->approach(index).name);
    return shown;
}

void MainWindow::ask_for_movie_file()
{
    if (!movie_->isEnabled())
        return;
    const QString alone = translated("Movie (*.webm)");
    const QString with_pictures = translated("Movie, and every frame as a picture (*.webm)");
    QString filter = alone;
    const int generation = generation_;
    const QString file = with_ending(QFileDialog::getSaveFileName(this, translated("Save a movie of the plans"),
                                         "movie.webm", alone + ";;" + with_pictures, &filter),
        ".webm");
    if (!file.isEmpty() && generation == generation_) // another case may have been opened while the dialog waited
        save_movie(file.toStdString(), filter == with_pictures);
}

void MainWindow::save_movie(const std::filesystem::path& file, bool with_pictures)
{
    run_export(QString::fromStdString(file.string()),
        [write = backend_.write_movie, shown = shown_plans(), file, with_pictures](const Job& job) {
            return write(
                shown, file, with_pictures ? file.parent_path() / (file.stem().string() + "-frames") : "", job);
        });
}

void MainWindow::ask_for_report_file()
{
    if (!report_->isEnabled())
        return;
    const int generation = generation_;
    const QString file = with_ending(
        QFileDialog::getSaveFileName(this, translated("Save the report"), "report.html", translated("Report (*.html)")),
        ".html");
    if (!file.isEmpty() && generation == generation_)
        save_report(file.toStdString());
}

void MainWindow::save_report(const std::filesystem::path& file)
{
    run_export(QString::fromStdString(file.string()),
        [write = backend_.write_report, shown = shown_plans(), file, book = language_book(),
            code = language().toStdString()](const Job& job) {
            if (!write(shown, file, job))
                return false;
            if (book != nullptr && !job.cancelled())
                translate_page(file, *book, code);
            return true;
        });
}

} // namespace retractor::ui
