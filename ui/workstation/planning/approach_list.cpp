#include "ui/workstation/planning/approach_list.h"

#include "planner/approach/approach_draft.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/planning/metric_rows.h"

#include <QPainter>
#include <QSignalBlocker>
#include <QStyledItemDelegate>
#include <QTextLayout>
#include <QTextOption>

namespace retractor::ui {

namespace {

    constexpr int kDetailRole = Qt::UserRole;
    constexpr int kColorRole = Qt::UserRole + 1;
    constexpr int kMargin = 12;
    constexpr int kDot = 10;

    constexpr int kMostNameLines = 2;

    QFont bold_of(QFont font)
    {
        font.setBold(true);
        return font;
    }

    /// The name in lines of at most that width, broken where its language breaks lines; the last one may be cut short.
    QStringList name_lines(const QString& name, const QFont& font, int width)
    {
        QTextLayout layout(name, font);
        QTextOption option;
        option.setWrapMode(QTextOption::WrapAtWordBoundaryOrAnywhere); // a long word alone is broken
        layout.setTextOption(option);
        layout.beginLayout();
        QStringList lines;
        for (QTextLine line = layout.createLine(); line.isValid(); line = layout.createLine()) {
            line.setLineWidth(width);
            if (lines.size() + 1 == kMostNameLines) {
                lines += QFontMetrics(font).elidedText(name.mid(line.textStart()), Qt::ElideRight, width);
                break;
            }
            lines += name.mid(line.textStart(), line.textLength()).trimmed();
        }
        layout.endLayout();
        return lines;
    }

    /// Draws an entry: a dot, the name in bold, and the detail below.
    class ApproachDelegate : public QStyledItemDelegate {
    public:
        explicit ApproachDelegate(QListWidget* list)
            : QStyledItemDelegate(list)
            , list_(*list)
        {
        }

        QSize sizeHint(const QStyleOptionViewItem& option, const QModelIndex& index) const override
        {
            const int width = text_rect({ 0, 0, list_.viewport()->width(), 1 }).width();
            const qsizetype lines = 1 + name_lines(index.data().toString(), bold_of(option.font), width).size();
            return { 0, static_cast<int>(lines) * option.fontMetrics.lineSpacing() + 2 * kMargin };
        }

        void paint(QPainter* painter, const QStyleOptionViewItem& option, const QModelIndex& index) const override
        {
            painter->save();
            painter->setRenderHint(QPainter::Antialiasing);
            const bool selected = option.state.testFlag(QStyle::State_Selected);
            if (selected)
                painter->fillRect(option.rect, option.palette.highlight());
            const int line = option.fontMetrics.lineSpacing();
            const QRect text = text_rect(option.rect);
            painter->setPen(Qt::NoPen);
            painter->setBrush(index.data(kColorRole).value<QColor>());
            painter->drawEllipse(option.rect.left() + kMargin, text.top() + (line - kDot) / 2, kDot, kDot);

            const QFont bold = bold_of(option.font);
            painter->setFont(bold);
            painter->setPen(selected ? Qt::white : option.palette.text().color());
            int top = text.top();
            for (const QString& part : name_lines(index.data().toString(), bold, text.width())) {
                painter->drawText(text.left(), top + QFontMetrics(bold).ascent(), part);
                top += line;
            }
            painter->setFont(option.font);
            painter->setPen(selected ? QColor(0xdd, 0xe8, 0xf2) : QColor(0xa4, 0xad, 0xb5));
            painter->drawText(text.left(), top + option.fontMetrics.ascent(),
                option.fontMetrics.elidedText(index.data(kDetailRole).toString(), Qt::ElideRight, text.width()));
            painter->restore();
        }

    private:
        static QRect text_rect(const QRect& entry)
        {
            return entry.adjusted(2 * kMargin + kDot, kMargin, -kMargin, -kMargin);
        }

        const QListWidget& list_;
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
            return QString::fromStdString((state.as_draft ? "Draft: " : "") + field_summary(state.field->metrics));
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
    setResizeMode(QListView::Adjust); // a name takes one line or two
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
