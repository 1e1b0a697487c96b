#include "ui/workstation/palpation/palpation_panel.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/view/controls.h"
#include "ui/workstation/view/theme.h"

#include "ui/workstation/palpation/strip_chart.h"

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QSignalBlocker>
#include <QVBoxLayout>

#include <algorithm>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr int kNamePx = 26, kDevicePx = 92;

    QString model_name(const std::string& model)
    {
        if (model == "fem")
            return "Finite elements";
        if (model == "springs")
            return "Springs";
        if (model == "spheres")
            return "Spheres";
        return QString::fromStdString(model);
    }

    QWidget* section(const QString& title, QWidget* content)
    {
        auto* box = new QWidget;
        auto* column = new QVBoxLayout(box);
        column->setContentsMargins(0, 0, 0, 6);
        column->setSpacing(4);
        auto* head = new QLabel(title);
        head->setStyleSheet(
            QString(kFaint) + " font-weight: bold; border-bottom: 1px solid #3b4249; padding-bottom: 2px;");
        column->addWidget(head);
        content->layout()->setContentsMargins(0, 0, 0, 0);
        column->addWidget(content);
        return box;
    }

} // namespace

PalpationPanel::PalpationPanel(std::vector<std::string> models, QWidget* parent)
    : QWidget(parent)
{
    auto* column = new QVBoxLayout(this);
    column->setSpacing(6);
    column->addWidget(section("Fingers", make_fingers()));
    column->addWidget(section("Forces at the hand", make_servo()));
    column->addWidget(section("Tissue", make_tissue(models)));
    template_ = section("Change elasticity with a template", make_template());
    column->addWidget(template_);
    column->addWidget(section("Show", make_view()));
    auto* last = new QHBoxLayout;
    record_ = button("Record", "Record the motion and the force of every finger at 1 kHz, for five minutes at most (R)",
        &PalpationPanel::on_record);
    last->addWidget(record_);
    last->addWidget(button(
        "Reset", "Restore the elasticity, the heart rate and the fingers of the scene", &PalpationPanel::on_reset));
    column->addLayout(last);
    column->addStretch(1);
}

void PalpationPanel::call(const std::function<void()>& function) const
{
    if (!quiet_ && function)
        function();
}

void PalpationPanel::give(planner::palpation::Command command)
{
    if (on_command)
        on_command(std::move(command));
}

QPushButton* PalpationPanel::button(const QString& text, const QString& tip, std::function<void()> PalpationPanel::*run)
{
    return button(text, tip, [this, run] { call(this->*run); });
}

QPushButton* PalpationPanel::button(const QString& text, const QString& tip, const std::function<void()>& run)
{
    auto* made = unfocused(new QPushButton(text), tip);
    connect(made, &QPushButton::clicked, this, run);
    return made;
}

QDoubleSpinBox* PalpationPanel::number(double low, double high, int decimals, double step, const QString& suffix)
{
    auto* spin = new QDoubleSpinBox;
    spin->setRange(low, high);
    spin->setDecimals(decimals);
    spin->setSingleStep(step);
    spin->setSuffix(suffix);
    spin->setKeyboardTracking(false);
    return spin;
}

QWidget* PalpationPanel::make_fingers()
{
    auto* box = new QWidget;
    auto* column = new QVBoxLayout(box);
    column->setSpacing(2);
    for (std::size_t f = 0; f < planner::kMostFingers; ++f) {
        FingerRow& row = rows_[f];
        row.row = new QWidget;
        auto* line = new QHBoxLayout(row.row);
        line->setContentsMargins(0, 0, 0, 0);
        line->setSpacing(6);
        row.name = new QLabel;
        row.name->setFixedWidth(kNamePx);
        row.force = new QLabel;
        row.force->setStyleSheet(QString("color: %1; font-size: 15pt; font-weight: bold;").arg(finger_color(f).name()));
        row.force->setAlignment(Qt::AlignRight | Qt::AlignVCenter);
        row.depth = new QLabel;
        row.depth->setStyleSheet(kFaint);
        row.depth->setAlignment(Qt::AlignRight | Qt::AlignVCenter);
        row.device = new QComboBox;
        row.device->setEditable(true);
        row.device->setInsertPolicy(QComboBox::NoInsert);
        row.device->addItems({ "mouse", "simulated", "simulated:firm", "touch" });
        row.device->setToolTip(
            "Device that moves this finger: the mouse, a simulated hand, a Touch (touch, touch:NAME, touch:#SERIAL), a "
            "device on another computer (udp:PORT) or a recording (replay:FILE)");
        row.device->setFixedWidth(kDevicePx);
        connect(row.device, qOverload<int>(&QComboBox::activated), this, [this] { call(on_setup); });
        connect(row.device->lineEdit(), &QLineEdit::returnPressed, this, [this] { call(on_setup); });
        line->addWidget(row.name);
        line->addWidget(row.device);
        line->addWidget(row.depth, 1);
        line->addWidget(row.force);
        column->addWidget(row.row);
    }
    auto* form = new QFormLayout;
    depth_ = number(0.0, 30.0, 2, 0.25, " mm");
    depth_->setToolTip(
        "Depth to which the left button presses a fingertip. The wheel changes the depth while the button is held");
    connect(depth_, qOverload<double>(&QDoubleSpinBox::valueChanged), this, [this](double mm) {
        if (!quiet_ && on_depth)
            on_depth(mm);
    });
    form->addRow("Press", depth_);
    through_ = unfocused(new QComboBox);
    through_->setToolTip("What is put through the wound: an index finger, or the shaft of an instrument");
    connect(through_, qOverload<int>(&QComboBox::activated), this, [this] { call(on_setup); });
    through_name_ = new QLabel("Reach in with");
    form->addRow(through_name_, through_);
    show_ways({});
    column->addLayout(form);
    auto* buttons = new QHBoxLayout;
    grip_ = unfocused(
        new QCheckBox("Grip"), "The selected finger grips the tissue under it and pulls the tissue along (G)");
    connect(grip_, &QCheckBox::toggled, this, [this](bool held) {
        if (!quiet_ && on_grip)
            on_grip(held);
    });
    buttons->addWidget(grip_);
    buttons->addStretch(1);
    buttons->addWidget(button("Lift all", "All fingers leave the tissue (Esc)", &PalpationPanel::on_lift));
    column->addLayout(buttons);
    return box;
}

QWidget* PalpationPanel::make_servo()
{
    auto* box = new QWidget;
    auto* column = new QVBoxLayout(box);
    column->setSpacing(4);
    servo_ = plain_label(kFaint);
    servo_->setMinimumHeight(2 * fontMetrics().lineSpacing() + 2);
    column->addWidget(servo_);
    fault_ = plain_label("background: #6e2323; color: #ffd8d4; padding: 6px; border-radius: 4px;");
    column->addWidget(fault_);
    rearm_ = button("Arm again", "Switch the forces on again; they return within half a second",
        [this] { give(planner::palpation::Rearm {}); });
    column->addWidget(rearm_);
    fault_->hide();
    rearm_->hide();
    return box;
}

QWidget* PalpationPanel::make_tissue(const std::vector<std::string>& models)
{
    auto* box = new QWidget;
    auto* form = new QFormLayout(box);
    model_ = unfocused(new QComboBox);
    for (const std::string& model : models)
        model_->addItem(model_name(model), QString::fromStdString(model));
    connect(model_, qOverload<int>(&QComboBox::activated), this, [this] { call(on_setup); });
    form->addRow("Model", model_);
    heart_rate_ = number(20.0, 300.0, 0, 5.0, " per minute");
    connect(heart_rate_, qOverload<double>(&QDoubleSpinBox::valueChanged), this, [this](double rate) {
        if (!quiet_)
            give(planner::palpation::SetHeartRate { rate });
    });
    form->addRow("Heart rate", heart_rate_);
    gain_ = number(0.1, 20.0, 1, 0.5, " times");
    gain_->setToolTip(
        "Factor for the forces that the hands feel. The numbers show the forces of the tissue without this factor");
    connect(gain_, qOverload<double>(&QDoubleSpinBox::valueChanged), this, [this] {
        gain_->setStyleSheet(gain_->value() == 1.0 ? "" : "background: #6a5518;");
        call(on_setup);
    });
    form->addRow("Force gain", gain_);
    notes_ = plain_label(kFaint);
    form->addRow(notes_);
    return box;
}

QWidget* PalpationPanel::make_template()
{
    auto* box = new QWidget;
    auto* form = new QFormLayout(box);
    shape_ = unfocused(new QComboBox);
    shape_->addItems({ "Sphere", "Box" });
    connect(shape_, qOverload<int>(&QComboBox::currentIndexChanged), this, [this](int index) {
        size_[1]->setVisible(index == 1);
        size_[2]->setVisible(index == 1);
        call(on_template);
    });
    form->addRow("Shape", shape_);
    auto* sizes = new QHBoxLayout;
    for (QDoubleSpinBox*& size : size_) {
        size = number(0.5, 200.0, 1, 1.0, "");
        size->setValue(10.0);
        size->setToolTip("Radius of the sphere, or half of each edge of the box (along x, y, z), in mm");
        connect(size, qOverload<double>(&QDoubleSpinBox::valueChanged), this, [this] { call(on_template); });
        sizes->addWidget(size);
    }
    size_[1]->hide();
    size_[2]->hide();
    form->addRow("Size, mm", sizes);
    const auto value = [&](QCheckBox*& check, QDoubleSpinBox*& spin, const char* name, bool on) {
        check = new QCheckBox(name);
        check->setChecked(on);
        check->setToolTip("A value that is not ticked stays unchanged");
        spin->setEnabled(on);
        connect(check, &QCheckBox::toggled, spin, &QWidget::setEnabled);
        form->addRow(check, spin);
    };
    modulus_ = number(1e-4, 100.0, 4, 0.1, " MPa");
    modulus_->setValue(3.0);
    ratio_ = number(-0.5, 0.4995, 4, 0.01, "");
    ratio_->setValue(0.48);
    value(changes_modulus_, modulus_, "Young's modulus", true);
    value(changes_ratio_, ratio_, "Poisson's ratio", false);
    role_ = unfocused(new QComboBox, "Whether the tissue inside the template is held or free to move");
    role_->addItems({ "unchanged", "held", "free" });
    form->addRow("Tissue inside", role_);
    auto* buttons = new QHBoxLayout;
    place_ = button(
        "Place", "Then click on the tissue to place the centre of the template (T)", &PalpationPanel::on_place);
    apply_ = button("Apply",
        "Give these values to the tissue inside the template. The fingers feel the change within moments",
        &PalpationPanel::on_apply);
    buttons->addWidget(place_);
    buttons->addWidget(apply_);
    form->addRow(buttons);
    edit_state_ = plain_label(kFaint);
    form->addRow(edit_state_);
    return box;
}

QWidget* PalpationPanel::make_view()
{
    auto* box = new QWidget;
    auto* column = new QVBoxLayout(box);
    column->setSpacing(2);
    const auto check = [&](const QString& text, const QString& tip) {
        auto* made = unfocused(new QCheckBox(text), tip);
        connect(made, &QCheckBox::toggled, this, [this] { call(on_view); });
        column->addWidget(made);
        return made;
    };
    hands_ = check("Hand", "Show a hand on the fingertips (H)");
    spheres_ = check(
        "Spheres inside", "Show the spheres that fill the organs. The spheres that a finger moves are bright (S)");
    organs_ = new QWidget;
    organ_rows_ = new QVBoxLayout(organs_);
    organ_rows_->setContentsMargins(0, 0, 0, 0);
    organ_rows_->setSpacing(2);
    column->addWidget(organs_);
    return box;
}

void PalpationPanel::show_organs(const std::vector<std::string>& organs)
{
    if (organs == organ_names_)
        return;
    organ_names_ = organs;
    for (QCheckBox* box : organ_boxes_)
        delete box;
    organ_boxes_.clear();
    for (const std::string& organ : organs) {
        auto* box = unfocused(new QCheckBox(QString::fromStdString(organ)));
        box->setChecked(true);
        connect(box, &QCheckBox::toggled, this, [this] { call(on_view); });
        organ_rows_->addWidget(box);
        organ_boxes_.push_back(box);
    }
    organs_->setVisible(organs.size() > 1);
}

void PalpationPanel::begin(const planner::PalpationSetup& setup, double depth, double deepest)
{
    quiet_ = true;
    known_ = setup;
    depth_->setRange(0.0, deepest);
    depth_->setValue(depth);
    gain_->setValue(setup.force_gain);
    model_->setCurrentIndex(model_->findData(QString::fromStdString(setup.model)));
    quiet_ = false;
    set_edit_place(false);
    show_snapshot({}, {});
}

void PalpationPanel::show_ways(const std::vector<planner::ThroughOpening>& ways)
{
    through_->clear();
    for (const planner::ThroughOpening& way : ways)
        through_->addItem(translated(way.name == "instrument" ? QString("an instrument") : QString("a finger")),
            QString::fromStdString(way.name));
    through_->setCurrentIndex(
        std::max(through_->findData(QString::fromStdString(known_.through)), ways.empty() ? -1 : 0));
    through_->setVisible(!ways.empty());
    through_name_->setVisible(!ways.empty());
}

planner::PalpationSetup PalpationPanel::setup() const
{
    planner::PalpationSetup setup = known_;
    if (through_->count() > 0)
        setup.through = through_->currentData().toString().toStdString();
    setup.model = model_->currentData().toString().toStdString();
    setup.force_gain = gain_->value();
    setup.press_mm = depth_->value();
    setup.devices.clear();
    for (const FingerRow& row : rows_)
        setup.devices.push_back(row.device->currentText().trimmed().toStdString());
    return setup;
}

haptics::ElasticTemplate PalpationPanel::chosen_template() const
{
    haptics::ElasticTemplate chosen;
    chosen.shape
        = shape_->currentIndex() == 0 ? haptics::ElasticTemplate::Shape::sphere : haptics::ElasticTemplate::Shape::box;
    for (int i = 0; i < 3; ++i)
        chosen.half_size[i] = size_[static_cast<std::size_t>(i)]->value();
    if (changes_modulus_->isChecked())
        chosen.youngs_modulus = modulus_->value();
    if (changes_ratio_->isChecked())
        chosen.poissons_ratio = ratio_->value();
    if (role_->currentIndex() > 0)
        chosen.role = role_->currentIndex() == 1 ? datasets::VertexRole::fixed : datasets::VertexRole::free;
    return chosen;
}

bool PalpationPanel::wants_spheres() const { return spheres_->isEnabled() && spheres_->isChecked(); }
bool PalpationPanel::wants_hands() const { return hands_->isChecked(); }

std::set<Label> PalpationPanel::hidden_organs() const
{
    std::set<Label> hidden;
    for (std::size_t i = 0; i < organ_boxes_.size(); ++i)
        if (!organ_boxes_[i]->isChecked())
            hidden.insert(static_cast<Label>(i + 1));
    return hidden;
}

void PalpationPanel::set_edit_place(bool placed)
{
    placed_ = placed;
    apply_->setEnabled(placed && can_edit_);
}

void PalpationPanel::show_depth(double mm)
{
    const QSignalBlocker quiet(depth_);
    depth_->setValue(mm);
}

void PalpationPanel::show_snapshot(
    const planner::PalpationSnapshot& snapshot, const std::vector<std::string>& scene_notes)
{
    const bool ready = snapshot.phase == planner::PalpationSnapshot::Phase::ready;
    quiet_ = true;
    if (ready) {
        known_ = snapshot.setup;
        // A refused setting returns to the present value.
        if (!snapshot.busy) {
            model_->setCurrentIndex(model_->findData(QString::fromStdString(snapshot.setup.model)));
            if (!gain_->hasFocus())
                gain_->setValue(snapshot.setup.force_gain);
            if (!heart_rate_->hasFocus())
                heart_rate_->setValue(snapshot.heart_rate);
            for (std::size_t f = 0; f < planner::kMostFingers; ++f)
                if (QComboBox* device = rows_[f].device; !device->hasFocus() && !device->lineEdit()->hasFocus())
                    device->setCurrentText(f < snapshot.setup.devices.size()
                            ? QString::fromStdString(snapshot.setup.devices[f])
                            : "mouse");
        }
        show_organs(snapshot.abilities.organs);
    }
    quiet_ = false;
    for (std::size_t f = 0; f < planner::kMostFingers; ++f)
        rows_[f].row->setVisible(f < std::max<std::size_t>(snapshot.fingers, 1));
    setEnabled(ready);
    can_edit_ = ready && snapshot.abilities.edits;
    template_->setVisible(can_edit_ || !ready); // leaves room for the controls of other models
    set_edit_place(placed_);
    heart_rate_->setEnabled(ready && snapshot.abilities.pulse);
    grip_->setEnabled(ready && snapshot.abilities.grips);
    spheres_->setEnabled(ready && snapshot.abilities.spheres);
    unwritten_ = snapshot.unwritten_recording;
    QString notes;
    for (const auto* of : { &scene_notes, &snapshot.notes })
        for (const std::string& note : *of)
            notes += (notes.isEmpty() ? "" : "\n") + QString::fromStdString(note);
    notes_->setText(notes);
    notes_->setVisible(!notes.isEmpty());
    // A form gives wrapped lines too little height. Without lines there is no such height (-1).
    notes_->setMinimumHeight(std::max(0, notes_->heightForWidth(notes_->width())));
    edits_ = snapshot.edits.size();
}

void PalpationPanel::show_frame(const planner::PalpationFrame& frame, std::size_t finger_in_hand,
    const std::array<bool, planner::kMostFingers>& out)
{
    const haptics::ServoState& state = frame.servo;
    for (std::size_t f = 0; f < std::min(state.finger_count, planner::kMostFingers); ++f) {
        const haptics::FingerContact& contact = state.contacts[f];
        const double force = contact.force.allFinite() ? planner::force_of_tissue(contact) : 0.0;
        rows_[f].name->setText(QString("%1%2").arg(f + 1).arg(f == finger_in_hand ? " \u25c2" : ""));
        rows_[f].name->setToolTip(f == finger_in_hand ? translated("Selected finger") : QString());
        rows_[f].force->setText(QString("%1 N").arg(force, 0, 'f', 3));
        rows_[f].depth->setText(contact.stopped && out[f] ? translated(QString("stopped"))
                : contact.touching                        ? QString("%1 mm").arg(contact.depth, 0, 'f', 2)
                : out[f]                                  ? QString("above")
                                                          : QString("away"));
    }
    const planner::ServoHealth& health = frame.health;
    servo_->setText(translated(QString("computed %1 times a second; %2 of %3 were skipped")
                                   .arg(health.rate_hz, 0, 'f', 0)
                                   .arg(health.missed)
                                   .arg(health.ticks + health.missed))
        + (health.note.empty() ? QString() : "\n" + translated("The computer gives them no priority."))
        + (health.device_problem.empty() ? QString() : "\n" + translated("A Touch reported a problem.")));
    QString why = translated(QString("A force takes %1 µs on average, and took %2 µs at most.")
                                 .arg(health.mean_us, 0, 'f', 0)
                                 .arg(health.worst_us, 0, 'f', 0));
    if (!health.note.empty())
        why += "\n" + QString::fromStdString(health.note);
    if (!health.device_problem.empty())
        why += "\n" + QString::fromStdString("Last problem of a Touch: " + health.device_problem);
    servo_->setToolTip(why);
    const bool fault = state.fault.kind != haptics::FaultKind::none;
    fault_->setVisible(fault);
    rearm_->setVisible(fault);
    if (fault)
        fault_->setText(translated("The forces were switched off: " + std::string(haptics::describe(state.fault))));
    edit_state_->setText(translated(frame.stiffness_pending ? QString("Computing the new stiffness …")
            : edits_ > 0 ? QString(edits_ == 1 ? "%1 edit in force" : "%1 edits in force").arg(edits_)
                         : QString()));
    record_->setText(translated(frame.recorded_s >= 0.0 ? QString("Stop (%1 s)").arg(frame.recorded_s, 0, 'f', 0)
            : unwritten_                                ? QString("Save the recording")
                                                        : QString("Record")));
    record_->setStyleSheet(frame.recorded_s < 0.0 ? "" : "background: #8c2b2b;");
}

QString PalpationPanel::force_text(std::size_t finger) const { return rows_[finger].force->text(); }
QString PalpationPanel::fault_text() const { return fault_->isHidden() ? QString() : fault_->text(); }

} // namespace retractor::ui
