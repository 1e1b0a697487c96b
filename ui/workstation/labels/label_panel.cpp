#include "ui/workstation/labels/label_panel.h"

#include "mesh/base/text_format.h"
#include "ui/scene/label_colors.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/view/controls.h"

#include <QButtonGroup>
#include <QCheckBox>
#include <QGridLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QListWidget>
#include <QPixmap>
#include <QPushButton>
#include <QSlider>
#include <QToolButton>
#include <QVBoxLayout>

#include <utility>

namespace retractor::ui {

namespace {

    constexpr int kLargestBrushMm = 40, kUsualBrushMm = 4;
    constexpr int kNameRole = Qt::UserRole, kIdRole = Qt::UserRole + 1;

    QIcon square(const Color& color)
    {
        constexpr int kSidePx = 12;
        QPixmap picture(kSidePx, kSidePx);
        picture.fill(QColor::fromRgbF(color.r, color.g, color.b));
        return QIcon(picture);
    }

} // namespace

LabelPanel::LabelPanel(QWidget* parent)
    : QWidget(parent)
{
    auto* column = new QVBoxLayout(this);
    column->setContentsMargins(8, 8, 8, 8);
    column->setSpacing(8);
    note_ = plain_label();
    note_->setObjectName("label_note");
    column->addWidget(note_);

    auto* row = new QHBoxLayout;
    brushes_ = new QButtonGroup(this);
    const auto add_brush = [&](LabelBrush brush, const QString& text, const QString& tip) {
        auto* button = unfocused(new QToolButton, tip);
        button->setText(text);
        button->setCheckable(true);
        button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
        brushes_->addButton(button, static_cast<int>(brush));
        row->addWidget(button);
    };
    add_brush(LabelBrush::paint, "Paint", "Drag on a slice to give it the chosen label");
    add_brush(LabelBrush::erase, "Erase", "Drag to take the chosen label away: it becomes what lies beside it");
    add_brush(LabelBrush::fill, "Fill", "Click into a region of a slice to give it the chosen label");
    brushes_->button(static_cast<int>(LabelBrush::paint))->setChecked(true);
    column->addLayout(row);

    size_text_ = plain_label();
    column->addWidget(size_text_);
    size_ = unfocused(new QSlider(Qt::Horizontal), "Radius of the brush");
    size_->setObjectName("brush_size");
    size_->setRange(1, kLargestBrushMm);
    size_->setValue(kUsualBrushMm);
    column->addWidget(size_);
    ball_ = unfocused(new QCheckBox("In all slices within reach"), "The brush is a ball, and not a disc in this slice");
    ball_->setObjectName("ball");
    column->addWidget(ball_);
    keeps_bone_ = unfocused(new QCheckBox("Keep bones"), "Bone and cartilage are not painted over");
    keeps_bone_->setChecked(true);
    column->addWidget(keeps_bone_);

    list_ = new QListWidget;
    list_->setObjectName("labels");
    column->addWidget(list_, 1);

    actions_ = new QButtonGroup(this);
    auto* grid = new QGridLayout;
    grid->setSpacing(4);
    int place = 0;
    const auto put = [&](QPushButton* button) {
        grid->addWidget(button, place / 2, place % 2);
        ++place;
    };
    put(add_button(Action::smooth, "Smooth", "Smooth the surface of the label"));
    put(add_button(Action::largest, "Largest piece", "Drop the islands of the label"));
    put(add_button(Action::between, "Between slices", "Fill the axial slices between those in which it was drawn"));
    put(add_button(Action::confirm, "Confirm", "The label was estimated; you have checked it"));
    put(add_button(Action::join, "Join with…", "Make the label a part of another one"));
    put(add_button(Action::rename, "Rename…", "Give the label another name, such as the number of a rib"));
    put(add_button(Action::add, "New label…", "Add a label, to be painted"));
    column->addLayout(grid);
    auto* end = new QHBoxLayout;
    end->addWidget(add_button(Action::discard, "Discard", "Take all corrections back"));
    end->addWidget(add_button(Action::save, "Save labels", "Write the labels into the case; plans are made anew"));
    column->addLayout(end);

    connect(brushes_, &QButtonGroup::idClicked, this, [this] { on_state(); });
    connect(size_, &QSlider::valueChanged, this, [this] {
        show_size();
        on_state();
    });
    for (QCheckBox* box : { ball_, keeps_bone_ })
        connect(box, &QCheckBox::toggled, this, [this] { on_state(); });
    connect(list_, &QListWidget::currentRowChanged, this, [this] {
        if (!showing_)
            on_state();
    });
    connect(list_, &QListWidget::itemClicked, this, [this] { on_click(); });
    connect(actions_, &QButtonGroup::idClicked, this, [this](int action) { on_action(static_cast<Action>(action)); });
    show_size();
}

QPushButton* LabelPanel::add_button(Action action, const QString& text, const QString& tip)
{
    auto* button = unfocused(new QPushButton(text), tip);
    button->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Fixed); // the pane may be narrow
    actions_->addButton(button, static_cast<int>(action));
    return button;
}

QPushButton& LabelPanel::button(Action action)
{
    return *static_cast<QPushButton*>(actions_->button(static_cast<int>(action)));
}

void LabelPanel::show_size() { size_text_->setText(translated(QString("Brush of %1 mm radius").arg(size_->value()))); }

void LabelPanel::show_session(const planner::LabelSession* session, const QString& waiting)
{
    note_->setText(translated(session == nullptr ? waiting
            : session->changed()                 ? "Corrected, not saved. Plans use the labels after Save labels."
                                 : "Choose a label, then paint on a slice. The wheel turns the slices."));
    std::vector<Row> rows;
    if (session != nullptr)
        for (const mesh::LabelInfo& info : session->table())
            rows.push_back({ info.id, info.name, session->is_estimated(info.name) });
    if (rows != rows_) {
        rows_ = std::move(rows);
        fill_list();
    }
    for (int row = 0; row < list_->count(); ++row) // volumes change with every stroke
        list_->item(row)->setText(words_of(
            rows_[static_cast<std::size_t>(row)], session->volume_ml(rows_[static_cast<std::size_t>(row)].id)));
    const std::string name = chosen();
    for (QAbstractButton* button : actions_->buttons())
        button->setEnabled(session != nullptr && !name.empty());
    button(Action::add).setEnabled(session != nullptr);
    button(Action::confirm).setEnabled(session != nullptr && session->is_estimated(name));
    for (const Action action : { Action::save, Action::discard })
        button(action).setEnabled(session != nullptr && session->changed());
    for (QAbstractButton* brush : brushes_->buttons())
        brush->setEnabled(session != nullptr);
}

/// "aneurysm, 88.7 ml (estimated)".
QString LabelPanel::words_of(const Row& row, double volume_ml)
{
    return translated(QString::fromStdString(readable(row.name)) + QString(", %1 ml").arg(volume_ml, 0, 'f', 1)
        + (row.estimated ? " (estimated)" : ""));
}

/// The chosen label stays chosen by its id, also under another name.
void LabelPanel::fill_list()
{
    const QListWidgetItem* before = list_->currentItem();
    const int kept = before == nullptr ? last_id_ : before->data(kIdRole).toInt();
    last_id_ = kept; // while the labels are read again, the list is empty
    showing_ = true;
    list_->clear();
    list_->setCurrentRow(-1);
    for (const Row& row : rows_) {
        auto* item = new QListWidgetItem(square(label_color(row.name)), {}, list_);
        item->setData(kNameRole, QString::fromStdString(row.name));
        item->setData(kIdRole, static_cast<int>(row.id));
    }
    list_->setCurrentRow(-1);
    for (int n = 0; n < list_->count(); ++n)
        if (list_->item(n)->data(kIdRole).toInt() == kept)
            list_->setCurrentRow(n);
    showing_ = false;
}

LabelBrushState LabelPanel::state() const
{
    return { .brush = static_cast<LabelBrush>(brushes_->checkedId()),
        .label = 0,
        .radius_mm = static_cast<double>(size_->value()),
        .ball = ball_->isChecked(),
        .keeps_bone = keeps_bone_->isChecked() };
}

std::string LabelPanel::chosen() const
{
    const QListWidgetItem* item = list_->currentItem();
    return item == nullptr ? std::string() : item->data(kNameRole).toString().toStdString();
}

void LabelPanel::choose(const std::string& name)
{
    for (int row = 0; row < list_->count(); ++row)
        if (list_->item(row)->data(kNameRole).toString().toStdString() == name)
            list_->setCurrentRow(row);
}

} // namespace retractor::ui
