#include "ui/workstation/planning/approach_list.h"

#include "planner/approach/approach_draft.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/planning/metric_rows.h"

#include <QPainter>
#include <QSignalBlocker>
#include <QStyledItemDelegate>

namespace retractor::ui {

namespace {

    constexpr int kDetailRole = Qt::UserRole;
    constexpr int kColorRole = Qt::UserRole + 1;
    constexpr int kMargin = 12;
    constexpr int kDot = 10;

    /// Draws an entry: a dot, the name in bold, and the detail below.
    class ApproachDelegate : public QStyledItemDelegate {
    public:
        using QStyledItemDelegate::QStyledItemDelegate;

        QSize sizeHint(const QStyleOptionViewItem& option, const QModelIndex&) const override
        {
            return { 0, 2 * option.fontMetrics.lineSpacing() + 2 * kMargin };
        }

        void paint(QPainter* painter, const QStyleOptionViewItem& option, const QModelIndex& index) const override
        {
            painter->save();
            painter->setRenderHint(QPainter::Antialiasing);
            const bool selected = option.state.testFlag(QStyle::State_Selected);
            if (selected)
                painter->fillRect(option.rect, option.palette.highlight());
            const int line = option.fontMetrics.lineSpacing();
            QRect text = option.rect.adjusted(2 * kMargin + kDot, kMargin, -kMargin, -kMargin);
            painter->setPen(Qt::NoPen);
            painter->setBrush(index.data(kColorRole).value<QColor>());
            painter->drawEllipse(option.rect.left() + kMargin, text.top() + (line - kDot) / 2, kDot, kDot);

            QFont bold = option.font;
            bold.setBold(true);
            painter->setFont(bold);
            painter->setPen(selected ? Qt::white : option.palette.text().color());
            const QFontMetrics bold_metrics(bold);
            painter->drawText(text.left(), text.top() + bold_metrics.ascent(),
                bold_metrics.elidedText(index.data().toString(), Qt::ElideRight, text.width()));
            painter->setFont(option.font);
            painter->setPen(selected ? QColor(0xdd, 0xe8, 0xf2) : QColor(0xa4, 0xad, 0xb5));
            painter->drawText(text.left(), text.top() + line + option.fontMetrics.ascent(),
                option.fontMetrics.elidedText(index.data(kDetailRole).toString(), Qt::ElideRight, text.width()));
            painter->restore();
        }
    };

    QString detail_of(const SessionModel& model, std::size_t index)
    {
        const ApproachState& state = model.state(index);
        switch (state.status) {
        case FieldStatus::closed:
            return QString::fromStdString(approach_summary(model.approach(index)));
        case FieldStatus::waiting:
            return QStringLiteral("waiting to be planned");
        case FieldStatus::planning:
            return QStringLiteral("being planned");
        case FieldStatus::cancelling:
            return QStringLiteral("being cancelled");
        case FieldStatus::planned:
            return QString::fromStdString(field_summary(state.field->metrics));
        case FieldStatus::failed:
            return QStringLiteral("failed: ") + QString::fromStdString(state.failure->what);
        }
        return {};
    }

    QColor color_of(const ApproachState& state)
    {
        switch (state.status) {
        case FieldStatus::closed:
            return QColor(0x6d, 0x75, 0x7d);
        case FieldStatus::waiting:
        case FieldStatus::planning:
        case FieldStatus::cancelling:
            return QColor(0xe2, 0xb1, 0x3c);
        case FieldStatus::planned:
            return QColor(light_look(planner::verdict_of(state.field->metrics).light).color);
        case FieldStatus::failed:
            return QColor(0xdc, 0x52, 0x52);
        }
        return {};
    }

} // namespace

ApproachList::ApproachList(QWidget* parent)
    : QListWidget(parent)
{
    setItemDelegate(new ApproachDelegate(this));
    setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    setAccessibleName("Approaches");
}

void ApproachList::show_model(const SessionModel& model)
{
    const QSignalBlocker quiet(this);
    while (count() > static_cast<int>(model.approach_count()))
        delete takeItem(count() - 1);
    while (count() < static_cast<int>(model.approach_count()))
        addItem(QString());
    for (int row = 0; row < count(); ++row) {
        const auto index = static_cast<std::size_t>(row);
        const QString detail = detail_of(model, index);
        const bool chosen = model.approach(index).name == model.chosen_approach();
        item(row)->setText((chosen ? "✓ " : "") + translated(planner::spoken_name(model.approach(index))));
        item(row)->setData(kDetailRole, translated(detail));
        item(row)->setData(kColorRole, color_of(model.state(index)));
        item(row)->setToolTip(QString::fromStdString(model.approach(index).name) + ": " + translated(detail)
            + (chosen ? translated("; chosen by " + model.decisions().choices.back().by) : QString()));
    }
    setCurrentRow(model.selected() ? static_cast<int>(*model.selected()) : -1);
}

} // namespace retractor::ui
