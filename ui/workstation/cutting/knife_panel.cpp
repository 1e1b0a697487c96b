#include "ui/workstation/cutting/knife_panel.h"

#include "planner/measures/bones/bone_limits.h"
#include "planner/measures/verdict.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/view/controls.h"
#include "ui/workstation/view/theme.h"

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QKeyEvent>
#include <QLabel>
#include <QListWidget>
#include <QPushButton>
#include <QScrollBar>
#include <QSignalBlocker>
#include <QSlider>
#include <QStringList>
#include <QVBoxLayout>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr const char* kDivide = "Divide the space";
    constexpr double kDeepestMm = 150.0;
    constexpr int kWidestMm = 40; ///< on each side
    constexpr double kStrongestN = 500.0; ///< the strongest retraction published is 349 N on one side
    constexpr double kTearingStrain = 1.0; ///< stretch to twice the length, which no tissue of a wall bears
    constexpr int kHookListPx = 110; ///< at most
    constexpr int kCutListPx = 96;
    constexpr double kFlatDeg = 5.0; ///< smallest angle that a cut guarantees, where the geometry allows it
    /// Published skin tension is 2 to 6 %.
    constexpr std::array kTensionsPercent { 0, 2, 4, 6 };
    constexpr int kUsualTension = 4;
    /// Radius of the tissue that Remove deletes, mm; 0: the loose piece.
    constexpr std::array kRemovalRadiiMm { 0, 5, 10, 20, 40 };

    QString omitted_text(const planner::CutEntry& cut)
    {
        if (cut.omitted.empty())
            return {};
        return QString(cut.taken_out.empty() ? "\na part of the line was not cut: "
                                             : "\na part of the ball was not removed: ")
            + QString::fromStdString(cut.omitted);
    }

    /// The reason for remaining flat elements; empty when there are none.
    QString angle_remark(const mesh::CutReport& report)
    {
        if (report.worst_dihedral_deg >= kFlatDeg)
            return {};
        const QString below = QString("\n⚠ The mesh has elements flatter than %1°: ").arg(kFlatDeg, 0, 'f', 0);
        if (report.tets_below_half_parent > 0)
            return below
                + QString(
                    "the cut passes close to faces or corners of %1 elements, and no better shape is possible there")
                      .arg(report.tets_below_half_parent);
        return below
            + QString("the elements were flat before the cut (%1°)").arg(report.worst_dihedral_before_deg, 0, 'f', 0);
    }

    /// A remark when the force exceeds that of any retractor; otherwise empty.
    QString force_remark(const planner::HookReport& report)
    {
        if (std::max(report.side_N[0], report.side_N[1]) <= kStrongestN)
            return {};
        return QString("⚠ One side pulls with more than %1 N, and no retractor pulls this hard. Check whether the bone "
                       "under the hooks is still uncut.")
            .arg(kStrongestN, 0, 'f', 0);
    }

    /// A remark when the tissue is stretched more than it bears; otherwise empty.
    QString strain_remark(const planner::HookReport& report)
    {
        if (report.hooks.empty() || !report.settled || report.strain.p99 <= kTearingStrain)
            return {};
        return QString(
            "⚠ The strain is above %1 %, and no tissue bears this strain. Open the wound less, or make the cut longer.")
            .arg(100.0 * kTearingStrain, 0, 'f', 0);
    }

    /// A remark when hooks hold each other back; otherwise empty.
    QString meeting_remark(const planner::HookReport& report)
    {
        if (report.meeting.empty())
            return {};
        return QString("⚠ %1 meet. The hooks stop there, because lips do not pass through each other.")
            .arg(QString::fromStdString(report.meeting));
    }

    /// A remark when surfaces overlap in the picture, which contact would prevent; otherwise empty.
    QString overlap_remark(const planner::HookReport& report)
    {
        constexpr double kSaidMm = 0.5; // smaller overlaps are not visible
        if (report.hooks.empty() || report.lip_overlap_mm < kSaidMm)
            return {};
        return QString("⚠ The lips overlap by up to %1 mm. This view computes no contact between the lips; a plan with "
                       "contact does.")
            .arg(report.lip_overlap_mm, 0, 'f', 1);
    }

    /// Whether the forces are those of the plan: matched to it, and the retractor is opened about as far.
    bool are_as_planned(const planner::HookReport& report, const std::optional<planner::PlannedForce>& plan)
    {
        constexpr double kNearMm = 5.0;
        return plan && report.force_factor
            && std::abs(report.retractors.front().opening_mm - plan->opening_mm) <= kNearMm;
    }

    /// A remark when only the tissue near the wound is computed well; otherwise empty.
    QString rough_remark(const planner::HookReport& report, const std::optional<planner::PlannedForce>& plan)
    {
        if (report.hooks.empty() || !(report.rough_forces || report.linear_only))
            return {};
        const QString text = "⚠ Do not rely on these forces: more of the wall moves than is computed well here. ";
        return text
            + (plan ? QString("Rely on the force of the plan, at %1 mm.").arg(plan->opening_mm, 0, 'f', 0)
                    : QString("Plan the approach for better ones."));
    }

    QString remarks(const planner::HookReport& report, const std::optional<planner::PlannedForce>& plan)
    {
        QStringList said { meeting_remark(report), overlap_remark(report), force_remark(report), strain_remark(report),
            are_as_planned(report, plan) ? QString() : rough_remark(report, plan) };
        said.removeAll({});
        return said.join('\n');
    }

    /// "2.1 N", "120 N"; a force that no hand and no instrument has, as where uncut bone is pulled apart, is no number.
    QString newtons(double force_N)
    {
        const double size = std::abs(force_N);
        return size <= 2.0 * kStrongestN ? QString("%1 N").arg(force_N, 0, 'f', size < 10.0 ? 1 : 0)
                                         : QString("more than %1 N").arg(2.0 * kStrongestN, 0, 'f', 0);
    }

    /// "Finochietto rib spreader open 45 of 200 mm, 120 N on each blade".
    QString retractor_text(const planner::RetractorState& retractor)
    {
        constexpr double kSaidImbalance = 0.05; // below, one figure says it
        const auto [first, second] = retractor.blade_N;
        const QString forces = retractor.force_N < 0.0
            ? QString("holds the lips back with %1").arg(newtons(-retractor.force_N))
            : retractor.imbalance > kSaidImbalance
            ? QString("%1 and %2 on its blades: not at rest").arg(newtons(first)).arg(newtons(second))
            : newtons(retractor.force_N) + " on each blade";
        return QString("%1 open %2 of %3 mm, %4")
            .arg(QString::fromStdString(planner::capital(planner::instrument_name(retractor.kind))))
            .arg(std::max(0.0, retractor.opening_mm), 0, 'f', 0)
            .arg(retractor.greatest_opening_mm, 0, 'f', 0)
            .arg(forces);
    }

    /// "Plan: 108 N (75 to 142 N) at 30 mm, 29 % of the target seen; all forces by hand are scaled by one factor, so
    /// that they meet it there".
    QString planned_force_text(const planner::PlannedForce& plan, bool matched)
    {
        QString text = QString(matched
                ? "Plan: %1 N (%2 to %3 N) at %4 mm, %5 % of the target seen; all forces by hand are scaled by one "
                  "factor, so that they meet it there"
                : "Plan: %1 N (%2 to %3 N) at %4 mm, %5 % of the target seen; not matched: forces by hand may be off "
                  "by two or three times")
                           .arg(plan.force_N, 0, 'f', 0)
                           .arg(plan.low_N, 0, 'f', 0)
                           .arg(plan.high_N, 0, 'f', 0)
                           .arg(plan.opening_mm, 0, 'f', 0)
                           .arg(QString::fromStdString(planner::two_digits(100.0 * plan.seen_share)));
        if (!plan.objections.empty())
            text += "\nThe plan objects: " + QString::fromStdString(plan.objections);
        return text;
    }

    /// Text of a hook: "left 1   12.3 of 15.0 mm, 60.0 N: yields".
    QString hook_text(const planner::HookReport& report, const planner::HookState& hook)
    {
        const fem::HookDrive& drive = hook.drive;
        const bool is_blade = std::ranges::any_of(report.retractors, [&](const planner::RetractorState& retractor) {
            return std::ranges::find(retractor.blades, hook.id) != retractor.blades.end();
        });
        const Vec3 moved = is_blade ? planner::moved_by_hand(report, hook) : hook.displacement;
        QString text = QString("%1   %2")
                           .arg(translated(QString::fromStdString(hook.name).replace('_', ' ')))
                           .arg(moved.norm(), 0, 'f', 1);
        if (!is_blade && !drive.force_N && (hook.yielded || std::isfinite(drive.grip_N_per_mm)))
            text += translated(QString(" of %1").arg(drive.displacement.norm(), 0, 'f', 1));
        text += " mm, " + translated(newtons(hook.force_N.norm()));
        QStringList why;
        if (drive.force_N)
            why += translated(QString("pulls with %1 N").arg(drive.force_N->norm(), 0, 'g', 4));
        if (std::isfinite(drive.grip_N_per_mm))
            why += translated(QString("grip of %1 N/mm").arg(drive.grip_N_per_mm, 0, 'g', 4));
        if (hook.yielded) // the hook holds at its own limit, or at the limit of all hooks
            why += translated("yields");
        else if (std::isfinite(drive.force_limit_N))
            why += translated(QString("holds up to %1 N").arg(drive.force_limit_N, 0, 'g', 4));
        return why.isEmpty() ? text : text + ": " + why.join(", ");
    }

    /// Text of removed tissue: "2.1 cm³ of skin".
    QString taken_out_text(const planner::CutEntry& cut)
    {
        return QString("%1 cm³%2 %3")
            .arg(cut.report.removed_volume_mm3 / 1000.0, 0, 'f', 1)
            .arg(cut.several_tissues ? ", mostly" : " of", QString::fromStdString(cut.taken_out));
    }

    /// "forwards", "to the right".
    QString way_text(planner::StrokeWay way)
    {
        const QString text = QString::fromStdString(std::string(planner::to_string(way)));
        return way == planner::StrokeWay::right || way == planner::StrokeWay::left ? "to the " + text : text;
    }

    /// What the list says of a cut: "Cut 1   204 mm long, 41 mm deep".
    QString entry_text(const planner::CutEntry& cut)
    {
        const mesh::CutReport& r = cut.report;
        const QString wound
            = r.lip_area_mm2 > 0.0 ? QString("\n%1 cm² of wound").arg(r.lip_area_mm2 / 100.0, 0, 'f', 1) : QString();
        if (!cut.taken_out.empty())
            return QString("Taken out %1   ").arg(cut.number) + (cut.restored ? "restored\n" : "") + taken_out_text(cut)
                + omitted_text(cut);
        if (cut.restored)
            return QString("Cut %1   restored").arg(cut.number) + wound;
        const QString length = QString("%1 mm long").arg(cut.length_mm, 0, 'f', 0);
        if (cut.divides) // its length may lie beyond the mesh in part
            return QString("Cut %1   under the skin, %2, %3 cm²")
                .arg(cut.number)
                .arg(way_text(*cut.divides))
                .arg(cut.report.lip_area_mm2 / 100.0, 0, 'f', 1);
        return QString("Cut %1   %2%3, %4 mm deep")
                   .arg(cut.number)
                   .arg(cut.as_planned ? "as planned, " : "", length)
                   .arg(cut.depth_mm, 0, 'f', 0)
            + omitted_text(cut);
    }

    /// What the cut did to the mesh; empty when it is not known.
    QString mesh_text(const planner::CutEntry& cut)
    {
        const mesh::CutReport& r = cut.report;
        if (cut.restored || cut.divides)
            return {};
        if (!cut.taken_out.empty())
            return QString("%1 elements removed, %2 cm² of new surface, %3 ms")
                .arg(r.tets_removed)
                .arg(r.lip_area_mm2 / 100.0, 0, 'f', 1)
                .arg(1e3 * r.seconds, 0, 'f', 1);
        return QString("%1 elements cut, %2 more for each, smallest angle %3°, %4 ms")
                   .arg(r.tets_crossed)
                   .arg(r.mean_increase(), 0, 'f', 1)
                   .arg(r.worst_dihedral_deg, 0, 'f', r.worst_dihedral_deg < kFlatDeg ? 1 : 0)
                   .arg(1e3 * r.seconds, 0, 'f', 1)
            + angle_remark(r);
    }

    /// What the last cut in force did to the mesh; empty without one.
    QString last_cut_text(const std::vector<planner::CutEntry>& cuts)
    {
        const auto last
            = std::find_if(cuts.rbegin(), cuts.rend(), [](const planner::CutEntry& cut) { return cut.in_force; });
        const QString text = last == cuts.rend() ? QString() : mesh_text(*last);
        return text.isEmpty() ? text : text + '\n';
    }

    QPushButton* add_button(
        QWidget& owner, QHBoxLayout& row, const QString& text, const QString& tip, const std::function<void()>& run)
    {
        auto* button = unfocused(new QPushButton(text), tip);
        QObject::connect(button, &QPushButton::clicked, &owner, run);
        row.addWidget(button);
        return button;
    }

} // namespace

KnifePanel::KnifePanel(QWidget* parent)
    : QScrollArea(parent)
{
    setWidgetResizable(true); // on a low screen one scrolls
    setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    auto* page = new QWidget;
    auto* column = new QVBoxLayout(page);
    column->addWidget(make_question());
    column->addLayout(make_settings());
    column->addLayout(make_planned_cuts());
    column->addLayout(make_buttons());
    column->addWidget(make_cut_list());
    column->addWidget(make_hooks());
    sight_ = plain_label("color: white;");
    column->addWidget(sight_);
    state_ = plain_label(kFaint);
    column->addWidget(state_);
    technical_ = unfocused(new QCheckBox("Technical"), "Numbers of mesh and solver, for whoever checks the program");
    column->addWidget(technical_);
    solver_ = plain_label(kFaint);
    solver_->hide();
    column->addWidget(solver_);
    connect(technical_, &QCheckBox::toggled, solver_, &QWidget::setVisible);
    for (QWidget* control :
        std::initializer_list<QWidget*> { depth_, yield_, tension_, removal_, instrument_, opening_ })
        control->installEventFilter(this);
    column->addStretch(1);
    setWidget(page);
    setMinimumWidth(page->minimumSizeHint().width() + verticalScrollBar()->sizeHint().width());
    show_snapshot(nullptr, 0.0);
}

void KnifePanel::show_sight(const QString& text)
{
    if (const QString said = translated(text); sight_->text() != said)
        sight_->setText(said);
    sight_->setVisible(!text.isEmpty());
}

QString KnifePanel::sight_text() const { return sight_->text(); }

QFormLayout* KnifePanel::make_settings()
{
    auto* form = new QFormLayout;
    depth_ = new QDoubleSpinBox;
    depth_->setRange(1.0, kDeepestMm);
    depth_->setDecimals(0);
    depth_->setSingleStep(5.0);
    depth_->setValue(planner::KnifeSettings {}.depth_mm);
    depth_->setSuffix(" mm");
    depth_->setToolTip("Depth of the cut below the skin");
    form->addRow("Depth", depth_);
    through_ = new QCheckBox("Through the wall");
    through_->setToolTip("The depth of the cut is the thickness of the wall where the stroke begins");
    connect(through_, &QCheckBox::toggled, depth_, [this](bool on) { depth_->setEnabled(!on); });
    form->addRow("", through_);
    bone_ = new QCheckBox("Bone too (saw)");
    bone_->setToolTip("The blade cuts bone and cartilage too. Without this option, bone and cartilage stay whole");
    form->addRow("", bone_);
    tension_ = unfocused(
        new QComboBox, "Stretch of the soft tissue before the cut. A wound gapes more when the stretch is larger");
    for (const int percent : kTensionsPercent)
        tension_->addItem(percent == 0 ? QString("none") : QString("%1 %").arg(percent), percent / 100.0);
    tension_->setCurrentIndex(tension_->findData(kUsualTension / 100.0));
    connect(tension_, qOverload<int>(&QComboBox::activated), this, [this] { tension_by_hand_ = true; });
    connect(tension_, qOverload<int>(&QComboBox::currentIndexChanged), this,
        [this] { give(planner::surgery::SetTension { tension() }); });
    form->addRow("Tension", tension_);
    removal_ = unfocused(new QComboBox,
        "What the Take out tool (X) removes where you press: a loose piece, or one tissue within this radius");
    for (const int radius : kRemovalRadiiMm)
        removal_->addItem(
            radius == 0 ? QString("a loose piece") : QString("one tissue within %1 mm").arg(radius), radius);
    form->addRow("Take out", removal_);
    return form;
}

QHBoxLayout* KnifePanel::make_planned_cuts()
{
    auto* buttons = new QHBoxLayout;
    cut_planned_ = add_button(*this, *buttons, "Cut as planned",
        "Cut the planned incision, with all that the plan divides beyond the skin", [this] {
            take_planned_tension();
            give(planner::surgery::CutAsPlanned {});
        });
    divide_ = add_button(*this, *buttons, kDivide, {}, [this] { give(planner::surgery::DivideBeyondCut {}); });
    return buttons;
}

/// What can be cut without drawing now.
void KnifePanel::show_planned_cuts(const planner::SurgerySnapshot* snapshot)
{
    const bool ready = snapshot != nullptr && snapshot->phase == planner::SurgerySnapshot::Phase::ready;
    const auto extent = ready ? snapshot->division : planner::DivisionExtent::skin;
    const bool wound = ready && std::ranges::any_of(snapshot->cuts, &planner::CutEntry::in_force);
    cut_planned_->setEnabled(ready && !wound && !snapshot->stroke_open);
    divide_->setEnabled(wound && !snapshot->stroke_open && extent != planner::DivisionExtent::skin);
    divide_->setText(translated(QString(planner::divides_sternum(extent) ? "Saw across" : kDivide)));
    divide_->setToolTip(translated(QString(planner::divides_sternum(extent)
            ? "Saw the sternum across at the lower end of the last cut, under the skin"
            : extent == planner::DivisionExtent::full
            ? "Divide intercostal muscle and pleura beyond both ends of the last cut, under the skin"
            : "The approach divides nothing beyond the skin")));
}

QHBoxLayout* KnifePanel::make_buttons()
{
    auto* buttons = new QHBoxLayout;
    const auto add = [&](const QString& text, const QString& tip, const std::function<void()>& run) {
        return add_button(*this, *buttons, text, tip, run);
    };
    undo_ = add("Undo", "Take the last cut or the last change of the hooks back (Ctrl+Z)",
        [this] { give(planner::surgery::Undo {}); });
    redo_ = add(
        "Redo", "Make the step that was undone last again (Ctrl+Shift+Z)", [this] { give(planner::surgery::Redo {}); });
    export_ = add("Export…", "Save the cut wall as VTU", [this] {
        if (on_export)
            on_export();
    });
    return buttons;
}

QListWidget* KnifePanel::make_cut_list()
{
    cuts_ = new QListWidget;
    cuts_->setWordWrap(true);
    cuts_->setFixedHeight(kCutListPx); // so that no row below moves when a text grows
    cuts_->setToolTip("Double-click a cut to go back (or forward) to the state just after the cut");
    connect(cuts_, &QListWidget::itemActivated, this, [this](QListWidgetItem* item) {
        give(planner::surgery::GoTo { static_cast<std::size_t>(cuts_->row(item)) + 1 });
    });
    return cuts_;
}

/// Keeps Ctrl+Z and letters from number fields, wherever the focus is: undo and redo belong to the cuts, and a letter
/// is no number.
bool KnifePanel::eventFilter(QObject* watched, QEvent* event)
{
    const bool of_page = watched == widget() || watched == viewport() || qobject_cast<QScrollBar*>(watched) != nullptr;
    if (event->type() == QEvent::Wheel && !of_page) { // scrolls the panel; it must not open a wound
        event->ignore();
        return true;
    }
    if (event->type() == QEvent::ShortcutOverride) {
        const auto& key = *static_cast<QKeyEvent*>(event);
        const bool undo = key.key() == Qt::Key_Z && (key.modifiers() & Qt::ControlModifier) != 0;
        const bool letter
            = key.key() >= Qt::Key_A && key.key() <= Qt::Key_Z && (key.modifiers() & ~Qt::ShiftModifier) == 0;
        if (undo || letter) {
            event->ignore();
            return true;
        }
    }
    return QScrollArea::eventFilter(watched, event);
}

QWidget* KnifePanel::make_question()
{
    question_ = new QWidget;
    question_->setObjectName("question");
    question_->setAttribute(Qt::WA_StyledBackground);
    question_->setStyleSheet("#question { background: #33424f; border-radius: 4px; }");
    auto* rows = new QVBoxLayout(question_);
    question_text_ = new QLabel;
    question_text_->setWordWrap(true);
    rows->addWidget(question_text_);
    auto* buttons = new QHBoxLayout;
    restore_ = new QPushButton("Restore");
    restore_->setToolTip("Prepare the wall and repeat these cuts");
    discard_ = new QPushButton("Discard");
    discard_->setToolTip("Begin with an uncut wall. The file of the cuts is kept under another name");
    for (QPushButton* button : { restore_, discard_ }) {
        buttons->addWidget(button);
        connect(button, &QPushButton::clicked, this, [this, button] {
            if (on_restore)
                on_restore(button == restore_);
        });
    }
    rows->addLayout(buttons);
    question_->hide();
    return question_;
}

QWidget* KnifePanel::make_hooks()
{
    auto* box = new QWidget;
    auto* column = new QVBoxLayout(box);
    column->setContentsMargins(0, 0, 0, 0);
    auto* form = new QFormLayout;
    opening_ = unfocused(new QSlider(Qt::Horizontal));
    opening_->setRange(0, kWidestMm);
    opening_text_ = new QLabel;
    auto* open = new QHBoxLayout;
    open->addWidget(opening_);
    open->addWidget(opening_text_);
    set_opening(0, false);
    connect(opening_, &QSlider::valueChanged, this, [this](int value) {
        opening_text_->setText(opening_text(value));
        if (by_share_)
            give(planner::surgery::PullHooksByShare { value / 100.0 });
        else
            give(planner::surgery::PullAllHooks { static_cast<double>(value) });
    });
    instrument_ = unfocused(new QComboBox,
        "What the Hooks tool (H) sets where you press on the edge of a wound. A retractor has a second blade on the "
        "other "
        "lip; drag a blade, or turn the wheel over it, to crank it open");
    instrument_->addItem("a hook");
    for (const planner::RetractorKind& kind : planner::built_in_retractors())
        instrument_->addItem(
            QString::fromStdString(planner::capital(planner::instrument_name(kind.kind)) + ": " + kind.meaning),
            QString::fromStdString(kind.kind));
    instrument_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
    instrument_->setMinimumContentsLength(12);
    form->addRow("Set", instrument_);
    form->addRow("Each side by", open);
    yield_ = new QDoubleSpinBox;
    yield_->setRange(0.0, kStrongestN);
    yield_->setDecimals(1);
    yield_->setSpecialValueText("never");
    yield_->setSuffix(" N");
    yield_->setToolTip("Largest force of a hook. A hook yields (slips) above this force");
    connect(yield_, qOverload<double>(&QDoubleSpinBox::valueChanged), this,
        [this] { give(planner::surgery::SetYield { yield_N() }); });
    form->addRow("Yield at", yield_);
    nonlinear_ = unfocused(new QCheckBox("Compute wide openings"),
        "When the mouse rests, the tissue near the wound is computed for large movements. Without this option the lips "
        "swell, and forces are wrong, where a wound opens by more than 20 to 30 mm");
    nonlinear_->setChecked(true);
    connect(nonlinear_, &QCheckBox::toggled, this, [this] { give(planner::surgery::SetNonlinear { nonlinear() }); });
    form->addRow("", nonlinear_);
    column->addLayout(form);
    auto* buttons = new QHBoxLayout;
    const auto add = [&](const QString& text, const QString& tip, const std::function<void()>& run) {
        return add_button(*this, *buttons, text, tip, run);
    };
    planned_ = add("As planned", "Set the hooks or the retractor of the approach and open them as planned", [this] {
        take_planned_tension();
        give(planner::surgery::TakePlannedHooks {});
    });
    hook_off_ = add("Take off", "Remove the hook, or the retractor, that is selected in the list",
        [this] { take_off_chosen_hook(); });
    hooks_off_
        = add("All off", "Remove all hooks and retractors. The wound closes, or gapes from the tension of the tissue",
            [this] { give(planner::surgery::TakeOffHooks {}); });
    column->addLayout(buttons);
    to_plan_ = unfocused(new QPushButton("Add as an approach"),
        "Adds a copy of the approach that is opened by this retractor as it is now: its place, kind and opening");
    connect(to_plan_, &QPushButton::clicked, this, [this] { plan_chosen_retractor(); });
    column->addWidget(to_plan_);
    hooks_ = new QListWidget;
    hooks_->setWordWrap(true);
    hooks_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    hooks_->setToolTip(
        "Select the hook tool with H. Press on the edge of a wound to set a hook or a retractor; drag it to pull");
    column->addWidget(hooks_);
    numbers_ = plain_label("color: white;");
    refusal_ = plain_label("color: #ff8a80;");
    column->addWidget(refusal_);
    column->addWidget(numbers_);
    return box;
}

void KnifePanel::give(planner::surgery::Command command)
{
    if (on_command)
        on_command(std::move(command));
}

void KnifePanel::take_off_chosen_hook()
{
    if (const int row = hooks_->currentRow(); row >= 0 && static_cast<std::size_t>(row) < hook_ids_.size())
        give(planner::surgery::TakeOffHook { hook_ids_[static_cast<std::size_t>(row)] });
}

/// Of several retractors the one that is selected in the list, else the one that was set last.
void KnifePanel::plan_chosen_retractor()
{
    if (report_.retractors.empty() || !on_plan_retractor)
        return;
    const int row = hooks_->currentRow();
    const fem::HookId chosen
        = row >= 0 && static_cast<std::size_t>(row) < hook_ids_.size() ? hook_ids_[static_cast<std::size_t>(row)] : -1;
    auto retractor = std::ranges::find_if(report_.retractors, [&](const planner::RetractorState& state) {
        return std::ranges::find(state.blades, chosen) != state.blades.end();
    });
    if (retractor == report_.retractors.end())
        retractor = std::prev(report_.retractors.end());
    Vec3 between = Vec3::Zero();
    for (const planner::HookState& hook : report_.hooks)
        if (std::ranges::find(retractor->blades, hook.id) != retractor->blades.end())
            between += 0.5 * hook.placement.arm;
    on_plan_retractor(*retractor, between);
}

double KnifePanel::yield_N() const
{
    return yield_->value() > 0.0 ? yield_->value() : std::numeric_limits<double>::infinity();
}

bool KnifePanel::nonlinear() const { return nonlinear_->isChecked(); }

QString KnifePanel::hook_numbers() const { return numbers_->text(); }
QString KnifePanel::technical_text() const { return solver_->text(); }
QString KnifePanel::hook_warning() const { return refusal_->text(); }

QString KnifePanel::opening_text() const { return opening_text_->text(); }

QString KnifePanel::opening_text(int value) const
{
    return by_share_ ? QString("%1 %").arg(value) : QString("%1 mm").arg(value);
}

/// The slider follows hooks that the mouse or the plan has moved, all of them together. A hook that pulls with a force
/// follows the slider as its plan states.
void KnifePanel::show_opening(const planner::HookReport& report)
{
    if (const std::optional<double> share = planner::share_of_plan(report.hooks)) {
        set_opening(static_cast<int>(std::lround(100.0 * *share)), true);
        return;
    }
    double mm = 0.0;
    for (const planner::HookState& hook : report.hooks)
        mm += planner::moved_by_hand(report, hook).dot(hook.placement.pull) / static_cast<double>(report.hooks.size());
    set_opening(static_cast<int>(std::lround(mm)), false);
}

void KnifePanel::set_opening(int value, bool by_share)
{
    const QSignalBlocker quiet(opening_);
    by_share_ = by_share;
    opening_->setRange(0, by_share ? 100 : widest_mm_);
    opening_->setValue(value);
    opening_->setToolTip(translated(
        QString(by_share ? "Opens all planned hooks to this percentage of their planned force or "
                           "displacement. A hook that you dragged with the mouse stays where it is"
                         : "Pulls every hook away from the opposite lip by this distance, in mm on each side. "
                           "Drag a single hook with the mouse")));
    opening_text_->setText(opening_text(opening_->value()));
}

void KnifePanel::show_hooks(const planner::SurgerySnapshot* snapshot)
{
    const bool ready = snapshot != nullptr && snapshot->phase == planner::SurgerySnapshot::Phase::ready;
    const planner::HookReport report = ready ? snapshot->hooks : planner::HookReport {};
    const auto count = static_cast<int>(report.hooks.size());
    while (hooks_->count() > count)
        delete hooks_->takeItem(hooks_->count() - 1);
    hook_ids_.clear();
    for (int i = 0; i < count; ++i) {
        const planner::HookState& hook = report.hooks[static_cast<std::size_t>(i)];
        if (hooks_->count() <= i)
            hooks_->addItem(QString());
        hooks_->item(i)->setText(hook_text(report, hook));
        hook_ids_.push_back(hook.id);
    }
    report_ = report;
    widest_mm_ = kWidestMm;
    for (const planner::RetractorState& retractor : report.retractors)
        widest_mm_ = std::max(widest_mm_, static_cast<int>(std::ceil(0.5 * retractor.greatest_opening_mm)));
    to_plan_->setVisible(!report.retractors.empty());
    hooks_->setVisible(count > 0);
    hooks_->setFixedHeight(
        std::min(kHookListPx, 2 * hooks_->frameWidth() + count * std::max(hooks_->sizeHintForRow(0), 1)));
    const bool wound = ready
        && std::any_of(
            snapshot->cuts.begin(), snapshot->cuts.end(), [](const planner::CutEntry& cut) { return cut.in_force; });
    planned_->setEnabled(wound && !snapshot->stroke_open && snapshot->planned_hooks > 0);
    planned_->setToolTip(translated(QString(!ready || snapshot->planned_hooks > 0
            ? "Set the hooks or the retractor of the approach and open them as planned"
            : "The approach has no hooks")));
    opening_->setEnabled(count > 0);
    hook_off_->setEnabled(count > 0);
    hooks_off_->setEnabled(count > 0);
    // Changes the unit at once. Otherwise a slider in mm would move hooks that are driven by their share of the plan.
    const bool other_unit = planner::share_of_plan(report.hooks).has_value() != by_share_;
    if (count == 0 || other_unit || (report.settled && !opening_->isSliderDown()))
        show_opening(report);
    const std::optional<planner::PlannedForce> plan = snapshot != nullptr ? snapshot->planned_force : std::nullopt;
    const QString warning = report.refusal.empty() ? remarks(report, plan) : QString::fromStdString(report.refusal);
    refusal_->setText(translated(warning));
    refusal_->setVisible(!warning.isEmpty());
    numbers_->setVisible(count > 0);
    if (count == 0)
        return;
    QString said;
    for (const planner::RetractorState& retractor : report.retractors)
        said += retractor_text(retractor) + '\n';
    if (report.hooks.size() != 2 * report.retractors.size()) // otherwise the retractors' forces say it
        said += QString("%1 on one side, %2 on the other\n")
                    .arg(newtons(report.side_N[0]))
                    .arg(newtons(report.side_N[1]));
    if (plan)
        said += planned_force_text(*plan, report.force_factor.has_value());
    numbers_->setText(translated(said.trimmed()));
}

/// Numbers of the hooks' solution; empty without hooks.
QString KnifePanel::solver_text(const planner::HookReport& report)
{
    if (report.hooks.empty())
        return {};
    const Vec3& at = report.strain.where;
    return QString("%1\n%4\n%2computed in %3 ms\n")
        .arg(report.settled ? QString("strain %1 % (99th percentile) at (%2, %3, %4) mm")
                                  .arg(100.0 * report.strain.p99, 0, 'f', 0)
                                  .arg(at.x(), 0, 'f', 0)
                                  .arg(at.y(), 0, 'f', 0)
                                  .arg(at.z(), 0, 'f', 0)
                            : QString("The strain follows when the mouse rests"))
        .arg(report.shown == planner::ShownAnswer::linear_since
                ? QString() // the sum of two solutions
                : QString("residual %1, ").arg(report.residual, 0, 'e', 0))
        .arg(report.frame_ms, 0, 'f', 0)
        .arg(QString::fromStdString(report.shown_text));
}

planner::KnifeSettings KnifePanel::settings() const
{
    return { .depth_mm = depth_->value(), .through_wall = through_->isChecked(), .cuts_bone = bone_->isChecked() };
}

std::optional<planner::RetractorKind> KnifePanel::instrument() const
{
    const std::string kind = instrument_->currentData().toString().toStdString();
    return kind.empty() ? std::nullopt : std::optional(planner::find_retractor(planner::built_in_retractors(), kind));
}

double KnifePanel::removal_radius_mm() const { return removal_->currentData().toDouble(); }

double KnifePanel::tension() const { return tension_->currentData().toDouble(); }

void KnifePanel::set_tension(double strain)
{
    if (const int index = tension_->findData(strain); index >= 0)
        tension_->setCurrentIndex(index);
}

void KnifePanel::take_planned_tension()
{
    const bool has_none = case_tension_item_ < 0; // else the case's own is chosen from the start
    if (has_none && !tension_by_hand_)
        set_tension(0.0);
}

void KnifePanel::offer_case_tension(double strain)
{
    if (case_tension_item_ >= 0) {
        const bool was_chosen = tension_->currentIndex() == case_tension_item_;
        tension_->removeItem(case_tension_item_);
        case_tension_item_ = -1;
        if (was_chosen)
            set_tension(kUsualTension / 100.0);
    }
    if (!(strain > 0.0)) {
        if (!tension_by_hand_)
            set_tension(kUsualTension / 100.0); // also where "as planned" took none
        tension_by_hand_ = false;
        return;
    }
    case_tension_item_ = tension_->count();
    tension_->addItem(translated(QString("%1 %, as planned").arg(100.0 * strain)), strain);
    tension_->setItemData(case_tension_item_,
        translated("The largest strain in the case. The other choices scale the strains of all tissues in proportion"),
        Qt::ToolTipRole);
    if (!tension_by_hand_)
        tension_->setCurrentIndex(case_tension_item_);
}

void KnifePanel::show_snapshot(const planner::SurgerySnapshot* snapshot, double draw_ms)
{
    const bool ready = snapshot != nullptr && snapshot->phase == planner::SurgerySnapshot::Phase::ready;
    const bool asking = snapshot != nullptr && snapshot->phase == planner::SurgerySnapshot::Phase::asking;
    question_->setVisible(asking);
    if (asking)
        question_text_->setText(translated(snapshot->saved_cuts == 0
                ? QString("The last session saved cuts that were undone. Restore them?")
                : QString("Restore the cuts of the last session (%1)?").arg(snapshot->saved_cuts)));
    show_planned_cuts(snapshot);
    show_hooks(snapshot);
    undo_->setEnabled(ready && !snapshot->to_undo.empty());
    redo_->setEnabled(ready && !snapshot->to_redo.empty());
    export_->setEnabled(ready && !snapshot->stroke_open);
    const int count = ready ? static_cast<int>(snapshot->cuts.size()) : 0;
    while (cuts_->count() > count)
        delete cuts_->takeItem(cuts_->count() - 1);
    for (int i = 0; i < count; ++i) {
        const planner::CutEntry& cut = snapshot->cuts[static_cast<std::size_t>(i)];
        if (cuts_->count() <= i)
            cuts_->addItem(QString());
        QListWidgetItem* item = cuts_->item(i);
        const QString text = translated(entry_text(cut) + (cut.in_force ? "" : "\nundone"));
        if (item->text() != text)
            item->setText(text);
        item->setForeground(cut.in_force ? QColor(0xe4, 0xe8, 0xeb) : QColor(0x6d, 0x75, 0x7d));
    }
    if (!ready)
        state_->setText(
            translated("Select the knife with K. Draw on the skin with the left button, and turn the camera with "
                       "the right button."));
    else
        state_->setText(translated(QString("Widest wound %1 mm%2")
                                       .arg(snapshot->gape_mm, 0, 'f', 1)
                                       .arg(snapshot->moving ? ", still opening" : "")));
    solver_->setText(!ready ? QString()
                            : last_cut_text(snapshot->cuts) + solver_text(snapshot->hooks)
                + QString("step %1 ms, surface %2 ms, opening %3 ms, picture %4 ms")
                      .arg(snapshot->step_ms, 0, 'f', 1)
                      .arg(snapshot->picture_ms, 0, 'f', 1)
                      .arg(snapshot->relax_ms, 0, 'f', 0)
                      .arg(draw_ms, 0, 'f', 0));
}

} // namespace retractor::ui
