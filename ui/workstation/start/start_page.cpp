#include "ui/workstation/start/start_page.h"

#include "ui/workstation/language/language.h"
#include "ui/workstation/view/controls.h"
#include "ui/workstation/view/theme.h"

#include <QCommandLinkButton>
#include <QHBoxLayout>
#include <QLabel>
#include <QListWidget>
#include <QPainter>
#include <QProgressBar>
#include <QPushButton>
#include <QVBoxLayout>

#include <cmath>

namespace retractor::ui {

namespace {

    constexpr QSize kThumbnail { 192, 144 };
    constexpr int kProgressSteps = 1000;

    QLabel* heading(const QString& text, double points)
    {
        auto* label = new QLabel(text);
        QFont font = label->font();
        font.setPointSizeF(points);
        font.setBold(true);
        label->setFont(font);
        return label;
    }

    /// A thumbnail of the usual size, with the picture in its middle.
    QIcon thumbnail(const QImage& picture)
    {
        QPixmap pixmap(kThumbnail);
        pixmap.fill(QColor(0x14, 0x18, 0x1c));
        if (!picture.isNull()) {
            QPainter painter(&pixmap);
            const QImage fitted = picture.scaled(kThumbnail, Qt::KeepAspectRatio, Qt::SmoothTransformation);
            painter.drawImage(
                (kThumbnail.width() - fitted.width()) / 2, (kThumbnail.height() - fitted.height()) / 2, fitted);
        }
        return QIcon(pixmap);
    }

    /// The name by which a person knows the case: its folder, and the file where that has a name of its own.
    QString name_of(const std::filesystem::path& file)
    {
        const QString folder = QString::fromStdString(file.parent_path().filename().string());
        return file.filename() == "case.json" ? folder
                                              : folder + "/" + QString::fromStdString(file.filename().string());
    }

} // namespace

StartPage::StartPage(QWidget* parent)
    : QWidget(parent)
{
    auto* outer = new QVBoxLayout(this);
    outer->setContentsMargins(32, 32, 32, 16);
    outer->setSpacing(8);
    outer->addWidget(heading("Retractor", 20.0));
    auto* subtitle = plain_label(kFaint);
    subtitle->setText("Plan an incision: draw it on the patient's skin, open it, and see what the surgeon will see.");
    outer->addWidget(subtitle);
    outer->addSpacing(16);

    page_ = new QWidget;
    auto* row = new QHBoxLayout(page_);
    row->setContentsMargins(0, 0, 0, 0);
    row->setSpacing(32);
    auto* column = new QVBoxLayout;
    column->setSpacing(8);
    column->addWidget(heading("Begin", 12.0));
    const auto add
        = [&](const QString& text, const QString& detail, const QString& name, std::function<void()> StartPage::*run) {
              auto* button = new QCommandLinkButton(text, detail);
              button->setObjectName(name);
              button->setIcon({});
              button->setMinimumWidth(280);
              connect(button, &QPushButton::clicked, this, [this, run] {
                  show_failure({});
                  if (this->*run)
                      (this->*run)();
              });
              column->addWidget(button);
          };
    add("Import a study…", "CT from a DICOM folder, disc, ZIP or image file", "import", &StartPage::on_import);
    add("Open a case…", "A case that was imported before", "open", &StartPage::on_open);
    add("New demo patient", "A made-up chest with an aneurysm and three approaches", "demo",
        &StartPage::on_demo_patient);
    add("Tour", "See in eight steps what this window does, with a demo patient", "tour", &StartPage::on_tour);
    add("Palpation trainer", "Feel a beating aortic arch with a hardened wall", "trainer", &StartPage::on_trainer);
    column->addStretch(1);
    row->addLayout(column);
    auto* recent_column = new QVBoxLayout;
    recent_column->setSpacing(8);
    recent_column->addWidget(heading("Recent cases", 12.0));
    no_recent_ = plain_label(kFaint);
    no_recent_->setText("Cases that you open are listed here. You can also drop a case, a folder of images or a ZIP "
                        "file on this window.");
    recent_column->addWidget(no_recent_, 1, Qt::AlignTop);
    recent_ = new QListWidget;
    recent_->setAccessibleName("Recent cases");
    recent_->setViewMode(QListView::IconMode);
    recent_->setResizeMode(QListView::Adjust);
    recent_->setMovement(QListView::Static);
    recent_->setIconSize(kThumbnail);
    recent_->setGridSize(QSize(kThumbnail.width() + 24, kThumbnail.height() + 56));
    recent_->setWordWrap(true);
    recent_->setStyleSheet("QListWidget { background: transparent; }");
    recent_column->addWidget(recent_, 1);
    row->addLayout(recent_column, 1);
    outer->addWidget(page_, 1);
    const auto open_recent = [this](QListWidgetItem* item) {
        if (!page_->isEnabled())
            return; // a double click is one request
        show_failure({});
        if (on_recent)
            on_recent(cases_.at(static_cast<std::size_t>(recent_->row(item))).file);
    };
    connect(recent_, &QListWidget::itemClicked, this, open_recent);
    connect(recent_, &QListWidget::itemActivated, this, open_recent);

    failure_ = plain_label("color: #ff8a80;");
    failure_->setTextInteractionFlags(Qt::TextSelectableByMouse);
    failure_->hide();
    outer->addWidget(failure_);
    auto* work_row = new QHBoxLayout;
    work_ = new QLabel;
    progress_ = new QProgressBar;
    progress_->setRange(0, kProgressSteps);
    progress_->setFixedWidth(280);
    progress_->setTextVisible(false);
    cancel_ = new QPushButton("Cancel");
    connect(cancel_, &QPushButton::clicked, this, [this] {
        if (on_cancel)
            on_cancel();
    });
    work_row->addWidget(work_);
    work_row->addWidget(progress_);
    work_row->addWidget(cancel_);
    work_row->addStretch(1);
    outer->addLayout(work_row);
    show_work({});
    show_recent({});
}

void StartPage::show_recent(const std::vector<RecentCase>& cases)
{
    cases_ = cases;
    recent_->clear();
    for (const RecentCase& recent : cases_) {
        auto* item = new QListWidgetItem(thumbnail(recent.picture),
            name_of(recent.file) + "\n" + recent.opened.toString("d MMM yyyy, hh:mm"), recent_);
        item->setToolTip(QString::fromStdString(recent.file.string()));
    }
    recent_->setVisible(!cases_.empty());
    no_recent_->setVisible(cases_.empty());
}

void StartPage::show_work(const QString& text, std::optional<double> fraction)
{
    const bool working = !text.isEmpty();
    page_->setEnabled(!working);
    work_->setText(translated(text));
    work_->setVisible(working);
    progress_->setValue(static_cast<int>(std::lround(kProgressSteps * fraction.value_or(0.0))));
    progress_->setVisible(working && fraction.has_value());
    cancel_->setVisible(working && fraction.has_value());
}

void StartPage::show_failure(const QString& text)
{
    failure_->setText(text);
    failure_->setVisible(!text.isEmpty());
}

} // namespace retractor::ui
