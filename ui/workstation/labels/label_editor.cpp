#include "ui/workstation/labels/label_editor.h"

#include "mesh/base/text_format.h"
#include "planner/case/unsaved_labels.h"
#include "ui/workstation/language/language.h"

#include <QInputDialog>
#include <QLineEdit>
#include <QMessageBox>
#include <QPainter>
#include <QPushButton>
#include <QWidget>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr int kSmoothVoxels = 1;
    constexpr int kKeepMs = 1000; ///< after the last change

    /// The voxel of a label that is nearest to its centre: of a bent structure the centre itself lies beside it.
    std::optional<Vec3> middle_voxel(const mesh::LabelVolume& labels, Label label)
    {
        Vec3 sum = Vec3::Zero();
        double count = 0.0;
        mesh::visit_voxels(labels, [&](int i, int j, int k, Label here) {
            if (here == label) {
                sum += Vec3(i, j, k);
                count += 1.0;
            }
        });
        if (!(count > 0.0))
            return std::nullopt;
        const Vec3 centre = sum / count;
        Vec3 nearest = centre;
        double least = std::numeric_limits<double>::infinity();
        mesh::visit_voxels(labels, [&](int i, int j, int k, Label here) {
            const double distance = here == label ? (Vec3(i, j, k) - centre).squaredNorm() : least;
            if (distance < least) {
                least = distance;
                nearest = Vec3(i, j, k);
            }
        });
        return labels.grid.world(nearest);
    }

    /// A circle of this many pixels across; an empty one is the usual pointer.
    QCursor circle_cursor(double across_px)
    {
        constexpr int kLeastPx = 3, kMostPx = 255;
        if (!(across_px > 0.0))
            return QCursor(Qt::CrossCursor);
        const int across = std::clamp(static_cast<int>(std::lround(across_px)), kLeastPx, kMostPx);
        QPixmap picture(across + 2, across + 2);
        picture.fill(Qt::transparent);
        QPainter painter(&picture);
        painter.setRenderHint(QPainter::Antialiasing);
        painter.setPen(QPen(Qt::white, 1.5));
        painter.drawEllipse(1, 1, across, across);
        painter.end();
        return QCursor(picture, across / 2 + 1, across / 2 + 1);
    }

} // namespace

LabelEditor::LabelEditor(PictureView& view, LabelPanel& panel, QWidget& window)
    : view_(view)
    , panel_(panel)
    , window_(window)
    , tool_(view)
{
    panel_.on_state = [this] {
        show_state();
        on_message({}); // what was missing may be there now
    };
    panel_.on_click = [this] { show_chosen(); };
    panel_.on_action = [this](LabelPanel::Action action) { act(action); };
    tool_.on_edit = [this] { note_change(); };
    tool_.on_refusal = [this](const QString& text) { on_message(text); };
    tool_.on_unlabelled = [this](std::size_t count) {
        on_message(QString("%1 voxels have no label now. Paint another label there.").arg(count));
    };
    keep_timer_.setSingleShot(true);
    keep_timer_.setInterval(kKeepMs);
    connect(&keep_timer_, &QTimer::timeout, this, [this] { keep_unsaved(); });
    tool_.on_size = [this](double across_px) { view_.setCursor(circle_cursor(across_px)); };
}

void LabelEditor::set_case(planner::Case planned_case, ReadLabels read)
{
    set_active(false);
    forget_unsaved();
    const bool same = !case_.folder.empty() && planned_case.folder == case_.folder;
    ++generation_;
    working_ = 0;
    reading_ = busy_ = false;
    panel_.setEnabled(true);
    tool_.set_session(nullptr);
    session_.reset();
    case_ = std::move(planned_case);
    read_ = std::move(read);
    unsaved_ = case_.folder.empty() ? std::filesystem::path() : planner::unsaved_labels_file(case_);
    waiting_ = read_ ? "Reading the labels …" : "Labels can be corrected where the case has a CT.";
    panel_.show_session(nullptr, waiting_);
    if (!same)
        panel_.forget_choice();
}

void LabelEditor::work(std::function<std::function<void()>()> make)
{
    ++working_;
    executor_.post([this, generation = generation_, make = std::move(make)](const Job&) {
        std::function<void()> deliver;
        try {
            deliver = make();
        } catch (...) {
            deliver = [this, failure = current_failure()] { on_failure(failure); };
        }
        QMetaObject::invokeMethod(
            this,
            [this, generation, deliver = std::move(deliver)] {
                if (generation != generation_)
                    return;
                --working_;
                deliver();
            },
            Qt::QueuedConnection);
    });
}

void LabelEditor::set_active(bool active)
{
    active = active && read_ != nullptr;
    if (active == active_)
        return;
    active_ = active;
    view_.set_tool(active ? &tool_ : nullptr);
    if (!active) {
        view_.unsetCursor();
        return;
    }
    if (session_ == nullptr && !reading_)
        read_labels();
    show_state();
}

void LabelEditor::read_labels()
{
    reading_ = true;
    waiting_ = "Reading the labels …";
    work([this, read = read_, file = unsaved_]() -> std::function<void()> {
        try {
            const std::shared_ptr<const mesh::LabelVolume> labels = read();
            const std::uint32_t sum = planner::sum_of(*labels);
            std::optional<std::vector<planner::LabelStep>> unsaved;
            std::optional<Failure> damage;
            try {
                if (!file.empty())
                    unsaved = planner::read_unsaved_labels(file, sum);
            } catch (...) {
                damage = current_failure();
            }
            return [this, labels, sum, unsaved = std::move(unsaved), damage] {
                reading_ = false;
                labels_sum_ = sum;
                session_ = std::make_unique<planner::LabelSession>(case_, labels);
                tool_.set_session(session_.get());
                show_state();
                on_labels();
                if (damage)
                    on_failure(*damage);
                else if (unsaved)
                    offer_unsaved(*unsaved);
            };
        } catch (...) {
            return [this, failure = current_failure()] {
                reading_ = false;
                waiting_ = "The labels cannot be read: " + QString::fromStdString(to_string(failure));
                show_state();
                on_failure(failure);
            };
        }
    });
}

void LabelEditor::mention_unsaved()
{
    std::error_code code;
    if (read_ && !unsaved_.empty() && std::filesystem::exists(unsaved_, code))
        on_message("Corrections of labels were not saved. Open Labels (C) to make them again.");
}

void LabelEditor::note_change()
{
    keep_timer_.start();
    on_labels();
}

void LabelEditor::keep_unsaved()
{
    if (session_ == nullptr || unsaved_.empty())
        return;
    work([this, file = unsaved_, sum = labels_sum_, steps = session_->steps()]() -> std::function<void()> {
        planner::write_unsaved_labels(file, sum, steps);
        return [] {};
    });
}

void LabelEditor::forget_unsaved()
{
    keep_timer_.stop();
    if (session_ == nullptr || unsaved_.empty() || asking_)
        return;
    executor_.post([file = unsaved_](const Job&) {
        std::error_code ignored;
        std::filesystem::remove(file, ignored);
    });
}

void LabelEditor::offer_unsaved(const std::vector<planner::LabelStep>& steps)
{
    const int generation = generation_;
    QMessageBox question(QMessageBox::Question, translated("Corrections of labels"),
        translated(QString("Corrections of labels were made and not saved (%1; the last: %2). Make them again?")
                       .arg(steps.size())
                       .arg(QString::fromStdString(steps.back().what))),
        QMessageBox::NoButton, &window_);
    QPushButton* again = question.addButton(translated("Make them again"), QMessageBox::AcceptRole);
    const QAbstractButton* forget = question.addButton(translated("Forget them"), QMessageBox::DestructiveRole);
    question.setEscapeButton(again); // they can be undone
    asking_ = true; // what is not answered stays
    question.exec();
    asking_ = false;
    if (generation != generation_ || session_ == nullptr)
        return;
    if (question.clickedButton() == forget)
        return forget_unsaved();
    on_message({});
    attempt([&](planner::LabelSession& session) {
        try {
            session.make_steps(steps);
        } catch (...) {
            while (session.to_undo())
                session.undo();
            throw;
        }
    });
}

void LabelEditor::show_state()
{
    panel_.show_session(session_.get(), waiting_);
    tool_.set_state(brush_state());
}

/// What the panel says, with the chosen label.
LabelBrushState LabelEditor::brush_state() const
{
    LabelBrushState state = panel_.state();
    if (session_ != nullptr)
        if (const mesh::LabelInfo* info = mesh::find_label(session_->table(), panel_.chosen()))
            state.label = info->id;
    return state;
}

/// Shows where the chosen label lies.
void LabelEditor::show_chosen()
{
    const mesh::LabelInfo* info = session_ == nullptr ? nullptr : mesh::find_label(session_->table(), panel_.chosen());
    if (info == nullptr)
        return;
    if (const auto place = middle_voxel(*session_->labels(), info->id))
        on_place(*place);
}

void LabelEditor::undo()
{
    if (session_ == nullptr || busy_ || !session_->to_undo())
        return;
    session_->undo();
    show_state();
    note_change();
}

void LabelEditor::redo()
{
    if (session_ == nullptr || busy_ || !session_->to_redo())
        return;
    session_->redo();
    show_state();
    note_change();
}

void LabelEditor::attempt(const std::function<void(planner::LabelSession&)>& change)
{
    if (session_ == nullptr)
        return;
    try {
        change(*session_);
    } catch (...) {
        return on_failure(current_failure());
    }
    show_state();
    note_change();
}

std::optional<std::string> LabelEditor::ask_for_label(
    const QString& title, const QString& question, const std::string& not_this)
{
    QStringList words;
    std::vector<std::string> names;
    for (const mesh::LabelInfo& info : session_->table())
        if (info.name != not_this) {
            names.push_back(info.name);
            words += QString::fromStdString(readable(info.name));
        }
    if (words.isEmpty())
        return std::nullopt;
    const int generation = generation_;
    bool chosen = false;
    const QString word
        = QInputDialog::getItem(&window_, translated(title), translated(question), words, 0, false, &chosen);
    const auto at = words.indexOf(word);
    // Another case may have been opened while the dialog waited.
    return chosen && at >= 0 && generation == generation_ ? std::optional(names[static_cast<std::size_t>(at)])
                                                          : std::nullopt;
}

std::optional<std::string> LabelEditor::ask_for_name(
    const QString& title, const QString& question, const std::string& proposed)
{
    const int generation = generation_;
    bool given = false;
    QString text = QInputDialog::getText(
        &window_, translated(title), translated(question), QLineEdit::Normal, QString::fromStdString(proposed), &given);
    text = text.trimmed().replace(' ', '_'); // names are words joined by underscores; the list shows spaces
    return given && generation == generation_ ? std::optional(text.toStdString()) : std::nullopt;
}

void LabelEditor::act(LabelPanel::Action action)
{
    using Action = LabelPanel::Action;
    if (session_ == nullptr || busy_)
        return;
    const std::string name = panel_.chosen();
    const QString words = QString::fromStdString(readable(name));
    const mesh::LabelInfo* info = mesh::find_label(session_->table(), name);
    const mesh::LabelFlags kept = kept_by(brush_state(), session_->table());
    const Label label = info == nullptr ? Label { 0 } : info->id;
    switch (action) {
    case Action::smooth:
        return edit_whole([label, kept](const mesh::LabelVolume& labels) {
            return datasets::smoothed(labels, label, kSmoothVoxels, kept);
        });
    case Action::largest:
        return edit_whole(
            [label](const mesh::LabelVolume& labels) { return datasets::without_islands(labels, label); });
    case Action::between:
        return edit_whole([label, kept](const mesh::LabelVolume& labels) {
            return datasets::interpolated(labels, label, datasets::nearest_axis(labels.grid, Vec3::UnitZ()), kept);
        });
    case Action::confirm:
        return attempt([&](planner::LabelSession& session) { session.confirm(name); });
    case Action::join:
        if (const auto into = ask_for_label("Join labels", "Make " + words + " a part of", name))
            attempt([&](planner::LabelSession& session) {
                session.join(name, *into);
                show_state();
                panel_.choose(*into);
            });
        return;
    case Action::rename:
        if (const auto new_name = ask_for_name("Rename a label", "New name of " + words, name))
            attempt([&](planner::LabelSession& session) { session.rename(name, *new_name); });
        return;
    case Action::add:
        return add_label();
    case Action::save:
        return save();
    case Action::discard:
        while (session_->to_undo())
            session_->undo();
        show_state();
        note_change();
        return;
    }
}

/// Makes an edit of a whole label on the executor: it may take a second.
void LabelEditor::edit_whole(const planner::LabelSession::MakeEdit& make)
{
    const std::shared_ptr<const mesh::LabelVolume> labels = session_->labels();
    const auto wait = [this](bool waits) {
        busy_ = waits;
        panel_.setEnabled(!waits);
        tool_.set_session(waits ? nullptr : session_.get());
    };
    wait(true);
    on_message("Working …");
    work([this, labels, make, wait]() -> std::function<void()> {
        try {
            auto made = std::make_shared<datasets::LabelEdit>(make(*labels));
            return [this, made, wait] {
                wait(false);
                attempt([&](planner::LabelSession& session) {
                    const bool changed = session.edit([&](const mesh::LabelVolume&) { return *made; });
                    on_message(changed ? QString::fromStdString("Done: " + made->what) : "There is nothing to change.");
                });
            };
        } catch (...) {
            return [this, wait, failure = current_failure()] {
                wait(false);
                on_failure(failure);
            };
        }
    });
}

void LabelEditor::add_label()
{
    struct Kind {
        const char* words;
        const char* material;
        mesh::Role role;
    };
    constexpr std::array kKinds { Kind { "a target, such as an aneurysm", "vessel", mesh::Role::target },
        Kind { "a structure at risk, such as a vessel", "vessel", mesh::Role::at_risk },
        Kind { "a bone of the wall, such as a rib", "bone", mesh::Role::wall },
        Kind { "an organ that hides the view", "muscle", mesh::Role::voxel } };
    const auto name = ask_for_name("New label", "Name, such as aneurysm or rib_left_4", {});
    if (!name)
        return;
    QStringList words;
    for (const Kind& kind : kKinds)
        words += translated(QString(kind.words));
    const int generation = generation_;
    bool chosen = false;
    const QString word
        = QInputDialog::getItem(&window_, translated("New label"), translated("What is it?"), words, 0, false, &chosen);
    const auto at = words.indexOf(word);
    if (!chosen || at < 0 || generation != generation_)
        return;
    const Kind& kind = kKinds.at(static_cast<std::size_t>(at));
    attempt([&](planner::LabelSession& session) {
        session.add_label(*name, kind.material, kind.role);
        show_state();
        panel_.choose(*name);
    });
}

void LabelEditor::save()
{
    planner::Case corrected;
    try {
        corrected = session_->corrected(present_case());
    } catch (...) {
        return on_failure(current_failure());
    }
    on_save(std::move(corrected), session_->labels());
}

} // namespace retractor::ui
