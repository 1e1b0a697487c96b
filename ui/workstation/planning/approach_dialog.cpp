#include "ui/workstation/planning/approach_dialog.h"

#include "mesh/base/text_format.h"
#include "planner/approach/retractors.h"
#include "planner/measures/bones/bone_limits.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/view/controls.h"

#include <QCheckBox>
#include <QComboBox>
#include <QDialogButtonBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QLineEdit>
#include <QPushButton>
#include <QSpinBox>
#include <QVBoxLayout>

#include <algorithm>
#include <array>
#include <cmath>

namespace retractor::ui {

namespace {

    constexpr double kSternalOpeningMm = 60.0; ///< first proposal; see docs/user/approaches.md
    constexpr double kHemisternalOpeningMm = 40.0;
    constexpr double kRibOpeningMm = 40.0;
    constexpr double kWidestMm = 200.0;
    constexpr int kHighestSpace = 2, kLowestSpace = 9, kUsualSpace = 4;
    constexpr int kSpaceOfItsOwn = kHighestSpace - 1; ///< the template chooses the space
    constexpr int kRight = 1, kSideOfItsOwn = -1; ///< of the sides; the template has its own, which its name says

    struct Kind {
        const char* words;
        const char* template_name;
        bool has_space, has_side;
        const char* retractor;
        double opening_mm;
    };
    constexpr std::array kKinds {
        Kind { "Median sternotomy", "median", false, false, "sternal", kSternalOpeningMm },
        Kind { "Upper hemisternotomy, J to the right", "hemisternotomy-j", true, false, "finochietto",
            kHemisternalOpeningMm },
        Kind { "Upper hemisternotomy, J to the left", "hemisternotomy-j-left", true, false, "finochietto",
            kHemisternalOpeningMm },
        Kind { "Upper hemisternotomy, T", "hemisternotomy-t", true, false, "finochietto", kHemisternalOpeningMm },
        Kind { "Thoracotomy between two ribs", "intercostal", true, true, "finochietto", kRibOpeningMm },
        Kind { "Left posterolateral thoracotomy", "distal", true, false, "finochietto", kRibOpeningMm },
        Kind { "Left anterior mini-thoracotomy (MIDCAB)", "midcab", true, false, "midcab", kRibOpeningMm },
        Kind {
            "Right anterior mini-thoracotomy (aortic valve)", "right-anterior", true, false, "midcab", kRibOpeningMm },
        Kind { "Right lateral mini-thoracotomy (mitral valve)", "right-lateral", true, false, "midcab", kRibOpeningMm },
    };

    struct HookSet {
        const char* words;
        const char* hooks;
    };
    constexpr std::array kHookSets { HookSet { "2 hooks", "2" }, HookSet { "4 hooks", "4" }, HookSet { "8 hooks", "8" },
        HookSet { "One blade on each lip, held by hand", "blade" } };
    constexpr const char* kNothing = "";
    constexpr const char* kAsItIs = "as it is";
    const QString kHooksPrefix = "hooks:";

    QDoubleSpinBox* millimetres(double largest, const QString& special = {})
    {
        auto* box = new QDoubleSpinBox;
        box->setRange(0.0, largest);
        box->setDecimals(0);
        box->setSuffix(" mm");
        box->setSpecialValueText(special);
        return box;
    }

} // namespace

std::vector<ApproachDialog::Target> possible_targets(const planner::Case& planned_case)
{
    std::vector<ApproachDialog::Target> targets;
    for (const mesh::Role role : { mesh::Role::target, mesh::Role::at_risk, mesh::Role::voxel })
        for (const mesh::LabelInfo& info : planned_case.label_table) {
            if (info.role != role || info.material == "bone")
                continue;
            std::string words = readable(info.name);
            if (planner::is_estimated(planned_case, info.name))
                words += " (estimated)";
            targets.emplace_back(info.name, words);
        }
    return targets;
}

ApproachDialog::ApproachDialog(Asks asks, const std::vector<Target>& targets, QWidget* parent)
    : QDialog(parent)
    , asks_(asks)
{
    setWindowTitle(asks == Asks::kind ? "New approach"
            : asks == Asks::drawn     ? "New approach through the drawn incision"
                                      : "Target and opening");
    setMinimumWidth(440);
    auto* column = new QVBoxLayout(this);
    auto* form = new QFormLayout;
    form->setHorizontalSpacing(16);
    form->setVerticalSpacing(8);
    column->addLayout(form);
    if (asks == Asks::kind)
        add_kind(*form);
    if (asks == Asks::drawn)
        add_drawn(*form);
    add_target_and_opening(*form, targets);
    name_ = new QLineEdit;
    name_->setPlaceholderText("named after the approach");
    name_->setObjectName("name");
    form->addRow("Name", name_);
    failure_ = plain_label("color: #ff8a80;");
    failure_->hide();
    column->addWidget(failure_);
    column->addStretch(1);
    auto* buttons = new QDialogButtonBox(QDialogButtonBox::Cancel);
    accept_ = buttons->addButton(asks == Asks::opening ? "Change" : "Add approach", QDialogButtonBox::AcceptRole);
    accept_->setDefault(true);
    column->addWidget(buttons);
    connect(buttons, &QDialogButtonBox::accepted, this, [this] {
        if (on_accept)
            on_accept();
    });
    connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
    translate_texts(*this);
    show_what_applies();
}

void ApproachDialog::add_kind(QFormLayout& form)
{
    kind_ = new QComboBox;
    kind_->setObjectName("kind");
    for (const Kind& kind : kKinds)
        kind_->addItem(kind.words);
    space_ = new QSpinBox;
    space_->setObjectName("space");
    space_->setRange(kSpaceOfItsOwn, kLowestSpace);
    space_->setPrefix("space ");
    space_->setValue(kUsualSpace);
    side_ = new QComboBox;
    side_->setObjectName("side");
    side_->addItems({ "Left", "Right" });
    form.addRow("Approach", kind_);
    form.addRow("Between ribs", space_);
    form.addRow("Side", side_);
    connect(kind_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this] {
        const Kind& kind = kKinds.at(static_cast<std::size_t>(kind_->currentIndex()));
        show_what_applies();
        space_->setValue(kind.has_side ? kUsualSpace : kSpaceOfItsOwn);
        opened_by_->setCurrentIndex(opened_by_->findData(QString(kind.retractor)));
        if (!opening_touched_)
            opening_->setValue(kind.opening_mm);
    });
}

void ApproachDialog::add_drawn(QFormLayout& form)
{
    divides_ = new QComboBox;
    divides_->setObjectName("divides");
    divides_->addItem("Soft tissue along the incision", static_cast<int>(planner::Divides::soft_tissue));
    divides_->addItem("The space between the ribs, beyond the incision too", static_cast<int>(planner::Divides::space));
    divides_->addItem("Soft tissue and the bone under the incision (saw)", static_cast<int>(planner::Divides::bone));
    depth_ = millimetres(kWidestMm, "through the wall");
    depth_->setObjectName("depth");
    organs_aside_ = new QCheckBox("Lungs and pericardium are held aside");
    organs_aside_->setChecked(true);
    form.addRow("Divides", divides_);
    form.addRow("Depth of the cut", depth_);
    form.addRow("", organs_aside_);
}

void ApproachDialog::add_target_and_opening(QFormLayout& form, const std::vector<Target>& targets)
{
    target_ = new QComboBox;
    target_->setObjectName("target");
    for (const Target& target : targets)
        target_->addItem(QString::fromStdString(target.second), QString::fromStdString(target.first));
    opened_by_ = new QComboBox;
    opened_by_->setObjectName("opened by");
    if (asks_ == Asks::opening)
        opened_by_->addItem("The same as now", kAsItIs);
    for (const planner::RetractorKind& kind : planner::built_in_retractors())
        opened_by_->addItem(
            QString::fromStdString(planner::capital(planner::instrument_name(kind.kind)) + ": " + kind.meaning),
            QString::fromStdString(kind.kind));
    for (const HookSet& set : kHookSets)
        opened_by_->addItem(set.words, kHooksPrefix + set.hooks);
    opened_by_->addItem("Nothing yet (only cut)", kNothing);
    opened_by_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
    opened_by_->setMinimumContentsLength(30);
    opening_ = millimetres(kWidestMm);
    opening_->setObjectName("opening");
    opening_->setMinimum(1.0);
    form.addRow("Target", target_);
    form.addRow("Opened by", opened_by_);
    form.addRow("Opening", opening_);
    const bool median = asks_ == Asks::kind; // the first kind of the list
    const char* first = asks_ == Asks::opening ? kAsItIs : median ? "sternal" : "finochietto";
    opened_by_->setCurrentIndex(opened_by_->findData(QString(first)));
    opening_->setValue(median ? kSternalOpeningMm : kRibOpeningMm);
    connect(opened_by_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this] { show_what_applies(); });
    connect(opening_, &QDoubleSpinBox::editingFinished, this, [this] { opening_touched_ = true; });
}

void ApproachDialog::show_what_applies()
{
    if (kind_ != nullptr) {
        const Kind& kind = kKinds.at(static_cast<std::size_t>(kind_->currentIndex()));
        space_->setEnabled(kind.has_space);
        space_->setSpecialValueText(kind.has_side ? QString() : translated("the space that suits the target"));
        space_->setMinimum(kind.has_side ? kHighestSpace : kSpaceOfItsOwn);
        side_->setEnabled(kind.has_side);
        if (side_->currentIndex() != kSideOfItsOwn)
            chosen_side_ = side_->currentIndex();
        side_->setCurrentIndex(kind.has_side ? chosen_side_ : kSideOfItsOwn);
    }
    // What pulls with a force, or does not pull yet, has no opening to change.
    opening_->setEnabled(
        opened_by_->currentData().toString() != kNothing && (!keeps_opening() || shown_.opened_by.opening_mm > 0.0));
}

bool ApproachDialog::keeps_opening() const { return opened_by_->currentData().toString() == kAsItIs; }

void ApproachDialog::show_draft(const planner::ApproachDraft& draft)
{
    shown_ = draft;
    name_->setText(QString::fromStdString(draft.name));
    if (draft.opened_by.opening_mm > 0.0) {
        constexpr double kWhole = 1e-6;
        const double opening = draft.opened_by.opening_mm;
        opening_->setDecimals(std::abs(opening - std::round(opening)) < kWhole ? 0 : 1);
        opening_->setMaximum(std::max(kWidestMm, opening));
        opening_->setValue(opening);
        opening_shown_mm_ = opening_->value();
    }
    target_->setCurrentIndex(target_->findData(QString::fromStdString(draft.target)));
    show_what_applies();
}

void ApproachDialog::set_usual_name(const QString& name) { name_->setPlaceholderText(translated(name)); }

void ApproachDialog::set_present_instrument(const QString& words)
{
    opened_by_->setItemText(opened_by_->findData(kAsItIs), translated("The same as now: " + words));
}

planner::ApproachDraft ApproachDialog::draft() const
{
    planner::ApproachDraft draft = shown_;
    draft.name = name_->text().trimmed().toStdString();
    draft.target = target_->currentData().toString().toStdString();
    if (kind_ != nullptr) {
        const Kind& kind = kKinds.at(static_cast<std::size_t>(kind_->currentIndex()));
        draft.template_name = kind.template_name;
        if (kind.has_space && space_->value() != kSpaceOfItsOwn)
            draft.template_name += ":" + std::to_string(space_->value());
        draft.left = side_->currentIndex() != kRight;
    }
    if (divides_ != nullptr) {
        draft.divides = static_cast<planner::Divides>(divides_->currentData().toInt());
        draft.depth_mm = depth_->value();
        draft.organs_aside = organs_aside_->isChecked();
    }
    const QString key = opened_by_->currentData().toString();
    draft.opened_by = {};
    if (key == kNothing)
        return draft;
    if (key == kAsItIs) {
        // What nobody changed is not rounded as the field shows it.
        if (opening_->isEnabled() && opening_->value() != opening_shown_mm_)
            draft.opened_by.opening_mm = opening_->value();
        else
            draft.opened_by.opening_mm = shown_.opened_by.opening_mm;
        return draft;
    }
    if (key.startsWith(kHooksPrefix))
        draft.opened_by.hooks = key.mid(kHooksPrefix.size()).toStdString();
    else
        draft.opened_by.retractor = key.toStdString();
    draft.opened_by.opening_mm = opening_->value();
    return draft;
}

void ApproachDialog::show_failure(const QString& text)
{
    failure_->setText(translated(text));
    failure_->setVisible(!text.isEmpty());
}

void ApproachDialog::set_busy(bool busy)
{
    accept_->setEnabled(!busy);
    setCursor(busy ? Qt::BusyCursor : Qt::ArrowCursor);
}

} // namespace retractor::ui
