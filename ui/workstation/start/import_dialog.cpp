#include "ui/workstation/start/import_dialog.h"

#include "datasets/labels/label_presets.h"
#include "mesh/base/error.h"
#include "planner/case/case.h"
#include "planner/case/import_case.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/start/case_folder.h"
#include "ui/workstation/view/controls.h"
#include "ui/workstation/view/theme.h"

#include <QAbstractButton>
#include <QApplication>
#include <QCheckBox>
#include <QComboBox>
#include <QDir>
#include <QFileDialog>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLineEdit>
#include <QListWidget>
#include <QPlainTextEdit>
#include <QProgressBar>
#include <QPushButton>
#include <QStackedWidget>
#include <QVBoxLayout>

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor::ui {

namespace {

    namespace fs = std::filesystem;

    constexpr QSize kThumbnail { 96, 96 };
    constexpr int kProgressSteps = 1000;
    constexpr int kProgressMs = 100;

    QString native(const fs::path& path) { return QDir::toNativeSeparators(QString::fromStdString(path.string())); }

    /// A folder that is not there yet, named after the study.
    fs::path proposed_folder(const fs::path& study)
    {
        const fs::path named = study.has_filename() ? study : study.parent_path();
        fs::path name = named.filename();
        while (name.has_extension() && name.has_stem())
            name = name.stem(); // "chest.nii.gz"
        return free_case_folder(name.empty() ? "case" : name.string());
    }

    QString in_lines(const QString& head, const std::vector<std::string>& lines)
    {
        QString text;
        for (const std::string& line : lines)
            text += "•  " + QString::fromStdString(line) + "\n";
        return text.isEmpty() ? text : head + "\n" + text + "\n";
    }

    QString findings(const planner::ImportedCase& imported)
    {
        std::vector<std::string> rough;
        for (const datasets::FoundStructure& structure : imported.structures)
            if (structure.rough)
                rough.push_back(structure.name + ": " + structure.how);
        return in_lines("Check these:", imported.warnings) + in_lines("Only estimated:", rough)
            + in_lines("Decided while reading:", imported.notes);
    }

    /// @throws InputError when the folder holds a case already
    void refuse_existing(const fs::path& case_file)
    {
        std::error_code code;
        if (fs::exists(case_file, code))
            throw InputError("there is a case in this folder already: choose another folder", case_file.string());
    }

} // namespace

QString time_left(double seconds_so_far, double fraction)
{
    constexpr double kLeastFraction = 0.05, kLeastSeconds = 2.0, kMinute = 60.0;
    if (fraction < kLeastFraction || fraction >= 1.0 || seconds_so_far < kLeastSeconds)
        return {};
    const double left = seconds_so_far * (1.0 - fraction) / fraction;
    return left < kMinute ? QString("about %1 s left in this step").arg(std::ceil(left))
                          : QString("about %1 min left in this step").arg(std::ceil(left / kMinute));
}

ImportDialog::ImportDialog(QWidget* parent)
    : QDialog(parent)
{
    setWindowTitle("Import a study");
    resize(760, 620);
    auto* column = new QVBoxLayout(this);
    column->setSpacing(8);
    pages_ = new QStackedWidget;
    pages_->addWidget(make_choices());
    pages_->addWidget(make_summary());
    column->addWidget(pages_, 1);
    failure_ = plain_label("color: #ff8a80;");
    failure_->setTextInteractionFlags(Qt::TextSelectableByMouse);
    failure_->hide();
    column->addWidget(failure_);
    insist_ = new QCheckBox("These labels are of this CT");
    insist_->setObjectName("insist");
    insist_->hide(); // until labels are refused
    column->addWidget(insist_);
    auto* row = new QHBoxLayout;
    work_ = new QLabel;
    progress_ = new QProgressBar;
    progress_->setRange(0, kProgressSteps);
    progress_->setTextVisible(false);
    progress_->setFixedWidth(180);
    import_ = new QPushButton("Import");
    import_->setObjectName("import");
    import_->setDefault(true);
    open_ = new QPushButton("Open the case");
    open_->setObjectName("open");
    open_->hide();
    cancel_ = new QPushButton("Cancel");
    cancel_->setObjectName("cancel");
    row->addWidget(progress_);
    row->addWidget(work_);
    row->addStretch(1);
    row->addWidget(import_);
    row->addWidget(open_);
    row->addWidget(cancel_);
    column->addLayout(row);
    connect(import_, &QPushButton::clicked, this, [this] { import(); });
    connect(cancel_, &QPushButton::clicked, this, [this] { reject(); });
    connect(open_, &QPushButton::clicked, this, [this] {
        accept();
        if (on_imported)
            on_imported(case_file_);
    });
    timer_.setInterval(kProgressMs);
    connect(&timer_, &QTimer::timeout, this, [this] { show_progress(); });
    translate_texts(*this);
    show_progress();
    show_what_applies();
}

QWidget* ImportDialog::make_study_row()
{
    auto* widget = new QWidget;
    auto* row = new QHBoxLayout(widget);
    row->setContentsMargins(0, 0, 0, 0);
    path_ = new QLineEdit;
    path_->setObjectName("study");
    path_->setPlaceholderText("DICOM folder or disc, ZIP archive, NIfTI, NRRD, MetaImage or VTI file");
    auto* folder = new QPushButton("Folder…");
    auto* file = new QPushButton("File…");
    row->addWidget(path_, 1);
    row->addWidget(folder);
    row->addWidget(file);
    connect(path_, &QLineEdit::returnPressed, this, [this] { set_study(path_->text().toStdString()); });
    connect(path_, &QLineEdit::editingFinished, this, [this] { // left by Tab or a click, or after Return
        const QString path = path_->text();
        const bool a_button_is_pressed = QApplication::mouseButtons() != Qt::NoButton
            && qobject_cast<QAbstractButton*>(QApplication::focusWidget()) != nullptr; // reading would disable it
        if (!path.isEmpty() && path != path_looked_at_ && !a_button_is_pressed)
            set_study(path.toStdString());
    });
    connect(folder, &QPushButton::clicked, this, [this] { ask_for_folder(); });
    connect(file, &QPushButton::clicked, this, [this] { ask_for_file(); });
    for (QPushButton* button : { folder, file })
        button->setAutoDefault(false);
    return widget;
}

QWidget* ImportDialog::make_labels()
{
    auto* widget = new QWidget;
    auto* column = new QVBoxLayout(widget);
    column->setContentsMargins(0, 0, 0, 0);
    find_labels_ = new QCheckBox("Find bones, lungs, heart, vessels and the layers of the wall in the CT (chest)");
    find_labels_->setObjectName("find labels");
    find_labels_->setChecked(true);
    column->addWidget(find_labels_);
    labels_ = new QListWidget;
    labels_->setAccessibleName("Label files");
    labels_->setMaximumHeight(72);
    auto* row = new QHBoxLayout;
    row->addWidget(labels_, 1);
    auto* buttons = new QVBoxLayout;
    const auto add_button = [&](const QString& text, auto run) {
        auto* button = new QPushButton(text);
        button->setAutoDefault(false);
        connect(button, &QPushButton::clicked, this, run);
        buttons->addWidget(button);
    };
    add_button("Add label file…", [this] {
        const QString file = QFileDialog::getOpenFileName(this, translated("Add labels"), {},
            translated("Label maps (*.nrrd *.seg.nrrd *.nii *.nii.gz *.mha *.mhd *.vti *.dcm);;All files (*)"));
        if (!file.isEmpty())
            add_labels(file.toStdString());
    });
    add_button("Add folder of masks…", [this] {
        const QString folder = QFileDialog::getExistingDirectory(this, translated("Add a folder of masks"));
        if (!folder.isEmpty())
            add_labels(folder.toStdString());
    });
    add_button("Remove", [this] {
        delete labels_->currentItem();
        show_what_applies();
    });
    row->addLayout(buttons);
    column->addLayout(row);
    preset_ = new QComboBox;
    preset_->addItem("Names as in the files", QString());
    for (const std::string& name : datasets::label_preset_names())
        preset_->addItem("Names of " + QString::fromStdString(name), QString::fromStdString(name));
    column->addWidget(preset_);
    return widget;
}

QWidget* ImportDialog::make_choices()
{
    auto* page = new QWidget;
    auto* column = new QVBoxLayout(page);
    column->setContentsMargins(0, 0, 0, 0);
    column->setSpacing(8);
    const auto add_head = [&](const QString& text) {
        auto* head = new QLabel(text);
        QFont font = head->font();
        font.setBold(true);
        head->setFont(font);
        column->addWidget(head);
    };
    add_head("Study");
    column->addWidget(make_study_row());
    images_ = new QListWidget;
    images_->setAccessibleName("Series");
    images_->setIconSize(kThumbnail);
    images_->setStyleSheet("QListWidget { border: 1px solid #3b4249; }");
    column->addWidget(images_, 1);
    add_head("Labels");
    column->addWidget(make_labels());
    add_head("Folder of the case");
    auto* row = new QHBoxLayout;
    case_folder_ = new QLineEdit;
    case_folder_->setObjectName("case folder");
    auto* choose = new QPushButton("Choose a folder…");
    choose->setAutoDefault(false);
    row->addWidget(case_folder_, 1);
    row->addWidget(choose);
    column->addLayout(row);
    connect(choose, &QPushButton::clicked, this, [this] {
        const QString folder = QFileDialog::getExistingDirectory(this, translated("Folder of the case"));
        if (!folder.isEmpty())
            set_case_folder(folder.toStdString());
    });
    connect(images_, &QListWidget::currentRowChanged, this, [this] { show_what_applies(); });
    connect(find_labels_, &QCheckBox::toggled, this, [this] { show_what_applies(); });
    connect(case_folder_, &QLineEdit::textEdited, this, [this] { folder_chosen_ = true; });
    connect(case_folder_, &QLineEdit::textChanged, this, [this] { show_what_applies(); });
    return page;
}

QWidget* ImportDialog::make_summary()
{
    findings_ = new QPlainTextEdit;
    findings_->setReadOnly(true);
    findings_->setAccessibleName("Findings of the import");
    return findings_;
}

void ImportDialog::ask_for_folder()
{
    const QString folder = QFileDialog::getExistingDirectory(this, translated("Folder or disc of the study"));
    if (!folder.isEmpty())
        set_study(folder.toStdString());
}

void ImportDialog::ask_for_file()
{
    const QString file = QFileDialog::getOpenFileName(this, translated("Archive or image of the study"), {},
        translated("Studies (*.zip DICOMDIR *.dcm *.nii *.nii.gz *.nrrd *.nhdr *.mha *.mhd *.vti);;All files (*)"));
    if (!file.isEmpty())
        set_study(file.toStdString());
}

void ImportDialog::work(const QString& what, std::function<std::function<void()>(const Job&)> task)
{
    ++working_;
    cancelling_ = false;
    work_text_ = what;
    step_.clear();
    show_failure({});
    show_what_applies();
    timer_.start();
    show_progress();
    executor_.post([this, task = std::move(task)](const Job& job) {
        std::function<void()> deliver;
        try {
            deliver = task(job);
        } catch (...) {
            deliver = [this, failure = current_failure()] {
                show_failure(QString::fromStdString(to_string(failure)));
                if (std::ranges::find(failure.fields, "accept_labels") != failure.fields.end())
                    insist_->show();
            };
        }
        QMetaObject::invokeMethod(
            this,
            [this, deliver = std::move(deliver)] {
                --working_;
                cancelling_ = false;
                deliver();
                show_progress();
                show_what_applies();
            },
            Qt::QueuedConnection);
    });
}

void ImportDialog::set_study(const fs::path& path)
{
    path_->setText(native(path));
    path_looked_at_ = path_->text();
    study_ = {};
    show_study();
    work("Looking through the study", [this, path](const Job& job) -> std::function<void()> {
        auto study = std::make_shared<Study>(read_study(path, job));
        if (job.cancelled())
            return [] {};
        return [this, study] {
            study_ = std::move(*study);
            show_study();
            if (!folder_chosen_)
                case_folder_->setText(native(proposed_folder(study_.path)));
            if (images_->currentRow() < 0)
                show_failure("This study has no CT: only slices of a CT can be imported.");
        };
    });
}

void ImportDialog::show_study()
{
    images_->clear();
    for (const StudyImage& image : study_.images) {
        QPixmap pixmap(kThumbnail);
        pixmap.fill(Qt::black);
        if (!image.picture.isNull())
            pixmap
                = QPixmap::fromImage(image.picture.scaled(kThumbnail, Qt::KeepAspectRatio, Qt::SmoothTransformation));
        auto* item = new QListWidgetItem(QIcon(pixmap), image.title + "\n" + image.detail, images_);
        if (!image.is_ct) {
            item->setFlags(item->flags() & ~(Qt::ItemIsEnabled | Qt::ItemIsSelectable));
            item->setToolTip(translated("Only slices of a CT can be imported."));
        }
    }
    for (std::size_t n = 0; n < study_.images.size(); ++n)
        if (study_.images[n].is_ct)
            return images_->setCurrentRow(static_cast<int>(n));
}

void ImportDialog::add_labels(const fs::path& path)
{
    labels_->addItem(native(path));
    find_labels_->setChecked(false); // what was drawn by hand is all of it, unless the user says otherwise
    if (case_folder_->text().isEmpty())
        case_folder_->setText(native(proposed_folder(path)));
    show_what_applies();
}

void ImportDialog::set_case_folder(const fs::path& folder)
{
    case_folder_->setText(native(folder));
    folder_chosen_ = true;
}

planner::ImportRequest ImportDialog::request() const
{
    planner::ImportRequest request;
    if (const int row = images_->currentRow(); row >= 0) {
        const StudyImage& image = study_.images.at(static_cast<std::size_t>(row));
        request.ct = image.path;
        request.series = image.series;
    }
    for (int n = 0; n < labels_->count(); ++n)
        request.labels.emplace_back(labels_->item(n)->text().toStdString());
    if (!request.labels.empty())
        request.preset = preset_->currentData().toString().toStdString();
    request.accept_labels = insist_->isChecked();
    request.autosegment = find_labels_->isChecked() && !request.ct.empty();
    return request;
}

void ImportDialog::import()
{
    if (!import_->isEnabled())
        return;
    if (path_->text() != path_looked_at_) // another study was typed, and the field left by this button
        return set_study(path_->text().toStdString());
    const fs::path case_file = fs::path(case_folder_->text().toStdString()) / planner::kCaseFileName;
    work("Importing", [this, case_file, request = request()](const Job& job) -> std::function<void()> {
        refuse_existing(case_file);
        planner::ImportedCase imported = planner::read_import(request, job);
        if (imported.cancelled || job.cancelled())
            return [] {};
        if (const auto warning = planner::identity_warning(request.ct, case_file))
            imported.warnings.push_back(*warning);
        planner::write_import(imported, case_file); // short, and not interrupted: the case is there, and is shown
        return [this, case_file, text = findings(imported)] { show_imported(case_file, text); };
    });
}

void ImportDialog::show_imported(const fs::path& case_file, const QString& text)
{
    case_file_ = case_file;
    findings_->setPlainText(translated("The case was written to " + native(case_file) + "\n\n"
        + (text.isEmpty() ? QString("There is nothing to check.") : text)));
    pages_->setCurrentIndex(1);
    open_->setDefault(true);
    open_->setFocus();
}

void ImportDialog::reject()
{
    if (working_ == 0)
        return QDialog::reject();
    executor_.cancel();
    cancelling_ = true;
    show_progress();
}

void ImportDialog::show_progress()
{
    const bool working = working_ > 0;
    progress_->setVisible(working);
    work_->setVisible(working);
    if (!working)
        return timer_.stop();
    const SerialExecutor::Progress now = executor_.progress();
    const QString step = QString::fromStdString(now.stage);
    if (step != step_ || !step_time_.isValid()) {
        step_ = step;
        step_time_.start();
    }
    progress_->setValue(static_cast<int>(std::lround(kProgressSteps * now.fraction)));
    QString text = translated(cancelling_ ? "Cancelling" : work_text_ + (step.isEmpty() ? QString() : ": " + step));
    if (const QString left = time_left(1e-3 * static_cast<double>(step_time_.elapsed()), now.fraction); !left.isEmpty())
        text += ", " + translated(left);
    work_->setText(text);
}

void ImportDialog::show_failure(const QString& text)
{
    failure_->setText(translated(text));
    failure_->setVisible(!text.isEmpty());
}

QString ImportDialog::failure() const { return failure_->isHidden() ? QString() : failure_->text(); }

void ImportDialog::show_what_applies()
{
    const bool imported = pages_->currentIndex() == 1;
    const bool has_image = images_->currentRow() >= 0, has_labels = labels_->count() > 0;
    pages_->widget(0)->setEnabled(working_ == 0);
    preset_->setEnabled(has_labels);
    find_labels_->setEnabled(has_image || study_.images.empty());
    import_->setVisible(!imported);
    import_->setEnabled(working_ == 0 && !case_folder_->text().trimmed().isEmpty()
        && ((has_image && (has_labels || find_labels_->isChecked())) || (path_->text().isEmpty() && has_labels)));
    open_->setVisible(imported);
    cancel_->setText(translated(imported ? "Close" : "Cancel"));
}

} // namespace retractor::ui
