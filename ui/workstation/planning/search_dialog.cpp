#include "ui/workstation/planning/search_dialog.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/approach/approach_draft.h"
#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/comparison.h"
#include "planner/measures/verdict.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/language/stage_words.h"
#include "ui/workstation/planning/approach_dialog.h"
#include "ui/workstation/planning/metric_rows.h"
#include "ui/workstation/view/background_picture.h"
#include "ui/workstation/view/controls.h"
#include "ui/workstation/view/theme.h"

#include <QCheckBox>
#include <QComboBox>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QHeaderView>
#include <QProgressBar>
#include <QPushButton>
#include <QScreen>
#include <QScrollArea>
#include <QSpinBox>
#include <QStackedWidget>
#include <QTableWidget>
#include <QVBoxLayout>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr int kProgressMs = 100, kProgressSteps = 1000, kMapWidth = 940;

    /// Columns of the table.
    enum Column { kPlace, kScore, kSeen, kReached, kForce, kVerdict, kColumns };

    QSpinBox* number(int least, int most, int value, const QString& unit, const QString& name)
    {
        auto* made = new QSpinBox;
        made->setRange(least, most);
        made->setValue(value);
        made->setSuffix(unit);
        made->setObjectName(name);
        return made;
    }

    QWidget* from_to(QSpinBox* from, QSpinBox* to)
    {
        auto* pair = new QWidget;
        auto* row = new QHBoxLayout(pair);
        row->setContentsMargins(0, 0, 0, 0);
        row->addWidget(from);
        row->addWidget(new QLabel("to"));
        row->addWidget(to);
        row->addStretch(1);
        // Neither passes the other.
        QObject::connect(from, QOverload<int>::of(&QSpinBox::valueChanged), to,
            [to](int value) { to->setValue(std::max(to->value(), value)); });
        QObject::connect(to, QOverload<int>::of(&QSpinBox::valueChanged), from,
            [from](int value) { from->setValue(std::min(from->value(), value)); });
        return pair;
    }

    QString sentence(std::string text) { return QString::fromStdString(planner::capital(std::move(text))); }

    QTableWidgetItem* cell(const std::string& text) { return new QTableWidgetItem(QString::fromStdString(text)); }

} // namespace

SearchDialog::SearchDialog(planner::Case planned_case, const planner::Weights& weights, Search search, QWidget* parent)
    : QDialog(parent)
    , case_(std::move(planned_case))
    , weights_(weights)
    , search_(std::move(search))
{
    setWindowTitle("Search for an incision");
    resize(1000, 420);
    auto* column = new QVBoxLayout(this);
    pages_ = new QStackedWidget;
    pages_->addWidget(make_request());
    pages_->addWidget(make_answer());
    column->addWidget(pages_, 1);
    failure_ = plain_label("color: #ff8a80;");
    failure_->hide();
    column->addWidget(failure_);
    auto* row = new QHBoxLayout;
    work_ = new QLabel;
    progress_ = new QProgressBar;
    progress_->setRange(0, kProgressSteps);
    progress_->setTextVisible(false);
    progress_->setFixedWidth(180);
    search_button_ = new QPushButton("Search");
    take_button_ = new QPushButton("Add to the case");
    back_ = new QPushButton("Back");
    close_ = new QPushButton("Cancel");
    row->addWidget(work_);
    row->addStretch(1);
    row->addWidget(progress_);
    for (QPushButton* button : { back_, search_button_, take_button_, close_ })
        row->addWidget(button);
    column->addLayout(row);
    connect(search_button_, &QPushButton::clicked, this, [this] { this->search(); });
    connect(take_button_, &QPushButton::clicked, this, [this] { take(); });
    connect(close_, &QPushButton::clicked, this, [this] { reject(); });
    connect(back_, &QPushButton::clicked, this, [this] {
        pages_->setCurrentIndex(0);
        show_what_applies();
    });
    timer_.setInterval(kProgressMs);
    connect(&timer_, &QTimer::timeout, this, [this] { show_progress(); });
    translate_texts(*this);
    show_progress();
    show_what_applies();
}

QWidget* SearchDialog::make_request()
{
    auto* page = new QWidget;
    auto* column = new QVBoxLayout(page);
    auto* head = plain_label(kFaint);
    head->setText(
        "Tries a thousand incisions by lines of sight, then cuts and opens the best as draft plans. This takes "
        "some minutes; the window can be used meanwhile.");
    column->addWidget(head);
    auto* form = new QFormLayout;
    form->setHorizontalSpacing(16);
    form->setVerticalSpacing(8);
    target_ = new QComboBox;
    target_->setObjectName("target");
    for (const auto& [name, words] : possible_targets(case_))
        target_->addItem(sentence(words), QString::fromStdString(name));
    side_ = new QComboBox;
    side_->setObjectName("side");
    side_->addItem("Both sides", "both");
    side_->addItem("Left", "left");
    side_->addItem("Right", "right");
    const planner::SearchLimits limits;
    highest_ = number(limits.highest_space, limits.lowest_space, limits.highest_space, {}, "highest");
    lowest_ = number(limits.highest_space, limits.lowest_space, limits.lowest_space, {}, "lowest");
    constexpr int kShortestMm = 20, kLongestMm = 400;
    shortest_ = number(kShortestMm, kLongestMm, static_cast<int>(limits.shortest_mm), " mm", "shortest");
    longest_ = number(kShortestMm, kLongestMm, static_cast<int>(limits.longest_mm), " mm", "longest");
    saw_ = new QCheckBox("The sternum may be sawn through");
    saw_->setObjectName("saw");
    saw_->setChecked(true);
    form->addRow("Target", target_);
    form->addRow("Between the ribs", side_);
    form->addRow("Spaces", from_to(highest_, lowest_));
    form->addRow("Length of the incision", from_to(shortest_, longest_));
    form->addRow("", saw_);
    column->addLayout(form);
    column->addStretch(1);
    return page;
}

QWidget* SearchDialog::make_answer()
{
    auto* page = new QWidget;
    auto* column = new QVBoxLayout(page);
    table_ = new QTableWidget(0, kColumns);
    table_->setObjectName("proposals");
    table_->setHorizontalHeaderLabels({ "Place", "Score", "Seen", "Two instruments", "Force", "Draft plan says" });
    table_->verticalHeader()->hide();
    table_->setEditTriggers(QAbstractItemView::NoEditTriggers);
    table_->setSelectionMode(QAbstractItemView::NoSelection);
    table_->setWordWrap(true);
    table_->horizontalHeader()->setSectionResizeMode(QHeaderView::ResizeToContents);
    for (const int wide : { kPlace, kVerdict }) // both have lines of words
        table_->horizontalHeader()->setSectionResizeMode(wide, QHeaderView::Stretch);
    table_->setStyleSheet("QTableView::indicator { width: 14px; height: 14px; border: 1px solid #8a949c; }"
                          "QTableView::indicator:checked { background: #4a9be0; }");
    table_->setMinimumHeight(200);
    connect(table_, &QTableWidget::itemChanged, this, [this] { show_what_applies(); });
    map_ = new QLabel;
    map_->setAlignment(Qt::AlignCenter);
    remarks_ = plain_label(kFaint);
    remarks_->setObjectName("remarks");
    column->addWidget(table_);
    column->addWidget(map_);
    column->addWidget(remarks_);
    column->addStretch(1);
    auto* scrolled = new QScrollArea; // screens may be small
    scrolled->setWidgetResizable(true);
    scrolled->setFrameShape(QFrame::NoFrame);
    scrolled->setWidget(page);
    return scrolled;
}

planner::SearchRequest SearchDialog::request() const
{
    planner::SearchRequest request { .target = { .label = target_->currentData().toString().toStdString() } };
    const QString side = side_->currentData().toString();
    request.limits.left = side != "right";
    request.limits.right = side != "left";
    request.limits.highest_space = highest_->value();
    request.limits.lowest_space = lowest_->value();
    request.limits.shortest_mm = shortest_->value();
    request.limits.longest_mm = longest_->value();
    request.limits.saw = saw_->isChecked();
    request.weights = weights_;
    request.sizing = case_.sizing;
    return request;
}

void SearchDialog::search()
{
    working_ = true;
    cancelling_ = false;
    show_failure({});
    show_what_applies();
    timer_.start();
    watch_.start();
    show_progress();
    executor_.post([this, request = request(), search = search_, present = case_](const Job& job) {
        std::function<void()> deliver;
        try {
            job.report("lines of sight", 0.0);
            auto found = std::make_shared<FoundProposals>(search(present, request, job));
            const bool cancelled = found->rays.status == planner::SearchStatus::cancelled
                || found->drafts.status == planner::SearchStatus::cancelled;
            deliver = [this, found, cancelled] {
                if (!cancelled)
                    show_answer(std::move(*found));
            };
        } catch (...) {
            deliver = [this, failure = current_failure()] { show_failure(sentence(failure.what)); };
        }
        QMetaObject::invokeMethod(
            this,
            [this, deliver = std::move(deliver)] {
                working_ = false;
                if (abandoned_)
                    return deleteLater();
                deliver();
                show_progress();
                show_what_applies();
            },
            Qt::QueuedConnection);
    });
}

void SearchDialog::show_answer(FoundProposals found)
{
    found_ = std::move(found);
    const std::vector<planner::PlannedProposal>& best = found_.drafts.best_first;
    table_->blockSignals(true);
    table_->setRowCount(static_cast<int>(best.size()));
    for (std::size_t n = 0; n < best.size(); ++n) {
        const int row = static_cast<int>(n);
        const planner::FieldMetrics& field = best[n].candidate.field;
        const planner::Verdict verdict = planner::verdict_of(field);
        const LightLook look = light_look(verdict.light);
        QTableWidgetItem* const name
            = cell(planner::compared_letter(n) + "  " + translated(sentence(best[n].proposal.words)).toStdString());
        name->setFlags(Qt::ItemIsEnabled | Qt::ItemIsUserCheckable);
        name->setCheckState(n == 0 ? Qt::Checked : Qt::Unchecked);
        table_->setItem(row, kPlace, name);
        table_->setItem(row, kScore, cell(formatted("%.0f", planner::score_of(best[n].candidate, weights_).points)));
        table_->setItem(row, kSeen, cell(planner::two_digits(100.0 * field.seen_best_eye) + " %"));
        table_->setItem(row, kReached, cell(planner::two_digits(100.0 * field.reached_by_two_instruments) + " %"));
        table_->setItem(row, kForce, cell(planner::two_digits(field.hook_force_N) + " N"));
        std::string words = translated(look.word).toStdString();
        if (!verdict.sentences.empty())
            words += ". " + translated(verdict.sentences.front()).toStdString();
        QTableWidgetItem* const said = cell(words);
        said->setForeground(QColor(look.color));
        std::string all;
        for (const std::string& one : verdict.sentences)
            all += (all.empty() ? "" : "\n") + one;
        said->setToolTip(translated(all));
        table_->setItem(row, kVerdict, said);
    }
    const auto fit_rows = [this] {
        constexpr int kFrame = 4;
        table_->resizeRowsToContents();
        table_->setMinimumHeight(
            table_->verticalHeader()->length() + table_->horizontalHeader()->sizeHint().height() + kFrame);
    };
    fit_rows();
    QTimer::singleShot(0, this, fit_rows); // by then the columns have their widths
    table_->blockSignals(false);
    map_->clear();
    if (!found_.map.rgb.empty())
        map_->setPixmap(QPixmap::fromImage(as_image(found_.map)).scaledToWidth(kMapWidth, Qt::SmoothTransformation));
    std::string remarks
        = formatted("%zu incisions were tried and %zu planned, in %.0f s. The numbers are of draft plans, "
                    "without error bars: plan what you add before you decide.",
            found_.rays.tried.size(), best.size() + found_.drafts.failed.size(),
            1e-3 * static_cast<double>(watch_.elapsed()));
    for (const std::string& why : found_.drafts.failed)
        remarks += "\nNo proposal: " + why;
    for (const std::string& place : found_.drafts.not_planned)
        remarks += "\nNot planned, as the time was over: " + place;
    for (const std::string& why : found_.refused)
        remarks += "\nDoes not fit: " + why;
    remarks_->setText(translated(remarks));
    pages_->setCurrentIndex(1);
    constexpr int kTall = 760;
    const QRect room = screen()->availableGeometry();
    resize(width(), std::min(std::max(height(), kTall), room.height()));
    move(x(), std::clamp(y(), room.top(), std::max(room.top(), room.bottom() - height())));
    if (best.empty() && found_.drafts.failed.empty())
        show_failure("None of these incisions was planned in time.");
    else if (best.empty())
        show_failure("None of these incisions can be proposed.");
}

void SearchDialog::take()
{
    std::vector<planner::Proposal> taken;
    for (int row = 0; row < table_->rowCount(); ++row)
        if (table_->item(row, kPlace)->checkState() == Qt::Checked)
            taken.push_back(found_.drafts.best_first.at(static_cast<std::size_t>(row)).proposal);
    try {
        on_take(taken);
        accept();
    } catch (...) {
        show_failure(sentence(to_string(current_failure())));
    }
}

void SearchDialog::abandon()
{
    executor_.cancel();
    abandoned_ = true;
    setAttribute(Qt::WA_DeleteOnClose, false);
    hide();
    if (!working_)
        deleteLater();
}

void SearchDialog::reject()
{
    if (!working_)
        return QDialog::reject();
    executor_.cancel();
    cancelling_ = true;
    show_progress();
}

void SearchDialog::show_progress()
{
    progress_->setVisible(working_);
    work_->setVisible(working_);
    if (!working_)
        return timer_.stop();
    const SerialExecutor::Progress now = executor_.progress();
    progress_->setValue(static_cast<int>(std::lround(kProgressSteps * now.fraction)));
    work_->setText(
        translated(cancelling_ ? "Cancelling" : "Searching: " + QString::fromStdString(stage_in_words(now.stage))));
}

void SearchDialog::show_failure(const QString& text)
{
    failure_->setText(translated(text));
    failure_->setVisible(!text.isEmpty());
}

QString SearchDialog::failure() const { return failure_->isHidden() ? QString() : failure_->text(); }

void SearchDialog::show_what_applies()
{
    const bool answered = pages_->currentIndex() == 1;
    pages_->widget(0)->setEnabled(!working_);
    search_button_->setVisible(!answered);
    search_button_->setEnabled(!working_ && target_->count() > 0);
    back_->setVisible(answered);
    take_button_->setVisible(answered);
    bool any = false;
    for (int row = 0; row < table_->rowCount(); ++row)
        any = any || table_->item(row, kPlace)->checkState() == Qt::Checked;
    take_button_->setEnabled(any);
    close_->setText(translated(working_ || !answered ? "Cancel" : "Close"));
}

} // namespace retractor::ui
