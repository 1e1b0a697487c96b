#include "ui/workstation/planning/comparison_chart.h"

#include "mesh/base/assert.h"
#include "ui/workstation/language/language.h"

#include <QHelpEvent>
#include <QPainter>
#include <QToolTip>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr int kCaptionHeight = 24, kRowHeight = 20, kGap = 8; // pixels
    constexpr int kLetterWidth = 18, kNumberGap = 6;
    const QColor kText(0xe4, 0xe8, 0xeb), kFaintText(0xa4, 0xad, 0xb5), kLeader(0x7c, 0xd9, 0x92);

    int height_of(const planner::ComparedMeasure& measure)
    {
        return kCaptionHeight + kRowHeight * static_cast<int>(measure.numbers.size()) + kGap;
    }

    QString text_of(const planner::ComparedMeasure& measure, std::size_t field)
    {
        const planner::ComparedNumber& number = measure.numbers[field];
        QString text = QString::fromStdString(planner::metric_text(*measure.metric, number.value));
        if (number.bar) {
            const QString unit = text.section(' ', 1);
            text = QString::fromStdString(planner::metric_number(*measure.metric, number.value)) + " \u00b1 "
                + QString::fromStdString(planner::metric_number(*measure.metric, *number.bar)) + " " + unit;
        }
        return text;
    }

    /// The end of the scale: the largest number with its bar.
    double scale_of(const planner::ComparedMeasure& measure)
    {
        double largest = 0.0;
        for (const planner::ComparedNumber& number : measure.numbers)
            largest = std::max(largest, std::abs(number.value) + number.bar.value_or(0.0));
        return largest > 0.0 ? largest : 1.0;
    }

    /// The width of the longest number, in bold as a leader is drawn.
    int width_of_numbers(const std::vector<planner::ComparedMeasure>& measures, QFont font)
    {
        font.setBold(true);
        const QFontMetrics bold(font);
        int widest = 0;
        for (const planner::ComparedMeasure& measure : measures)
            for (std::size_t n = 0; n < measure.numbers.size(); ++n)
                widest = std::max(widest, bold.horizontalAdvance(text_of(measure, n)));
        return widest;
    }

} // namespace

QColor compared_color(std::size_t n)
{
    static const std::array<QColor, 6> colors { QColor(0x56, 0xb4, 0xe9), QColor(0xe6, 0x9f, 0x00),
        QColor(0x00, 0xb3, 0x84), QColor(0xcc, 0x79, 0xa7), QColor(0xf0, 0xe4, 0x42), QColor(0xd5, 0x5e, 0x00) };
    return colors[n % colors.size()];
}

ComparisonChart::ComparisonChart(QWidget* parent)
    : QWidget(parent)
{
    setObjectName("comparison chart");
    setAccessibleName("Comparison of the planned approaches");
}

void ComparisonChart::show_fields(const std::vector<planner::FieldMetrics>& fields, std::vector<std::size_t> places)
{
    RETRACTOR_ASSERT(places.size() == fields.size());
    places_ = std::move(places);
    measures_ = planner::compared_measures(fields);
    int height = 0;
    QString spoken;
    for (const planner::ComparedMeasure& measure : measures_) {
        height += height_of(measure);
        spoken += QString(measure.metric->caption) + ":";
        for (std::size_t n = 0; n < measure.numbers.size(); ++n)
            spoken
                += " " + QString::fromStdString(planner::compared_letter(places_[n])) + " " + text_of(measure, n) + ";";
        spoken += "\n";
    }
    setAccessibleDescription(spoken);
    constexpr int kShortestBar = 40;
    setMinimumSize(kLetterWidth + kShortestBar + kNumberGap + width_of_numbers(measures_, font()), height);
    update();
}

void ComparisonChart::paintEvent(QPaintEvent*)
{
    QPainter painter(this);
    painter.setRenderHint(QPainter::Antialiasing);
    const int number_width = width_of_numbers(measures_, painter.font()); // no digit is cut off
    const double left = kLetterWidth, right = width() - number_width - kNumberGap, room = std::max(10.0, right - left);
    double y = 0.0;
    for (const planner::ComparedMeasure& measure : measures_) {
        painter.setPen(kFaintText);
        painter.drawText(QRectF(0.0, y, width(), kCaptionHeight), Qt::AlignVCenter,
            painter.fontMetrics().elidedText(translated(measure.metric->caption), Qt::ElideRight, width()));
        y += kCaptionHeight;
        const double scale = room / scale_of(measure);
        for (std::size_t n = 0; n < measure.numbers.size(); ++n, y += kRowHeight) {
            const bool leads = measure.leader == n;
            QFont font = painter.font();
            font.setBold(leads);
            painter.setFont(font);
            painter.setPen(compared_color(places_[n]));
            painter.drawText(QRectF(0.0, y, left, kRowHeight), Qt::AlignVCenter,
                QString::fromStdString(planner::compared_letter(places_[n])));
            const planner::ComparedNumber& number = measure.numbers[n];
            const double end = left + scale * std::abs(number.value), middle = y + kRowHeight / 2.0;
            painter.fillRect(QRectF(left, middle - 5.0, end - left, 10.0), compared_color(places_[n]));
            if (number.bar) {
                const double reach = scale * *number.bar;
                painter.setPen(QPen(kText, 1.5));
                const double from = std::max(left, end - reach);
                painter.drawLine(QPointF(from, middle), QPointF(end + reach, middle));
                painter.drawLine(QPointF(end + reach, middle - 4.0), QPointF(end + reach, middle + 4.0));
                if (end - reach >= left)
                    painter.drawLine(QPointF(from, middle - 4.0), QPointF(from, middle + 4.0));
            }
            painter.setPen(leads ? kLeader : kText);
            painter.drawText(QRectF(right + kNumberGap, y, number_width, kRowHeight), Qt::AlignVCenter | Qt::AlignRight,
                text_of(measure, n));
            font.setBold(false);
            painter.setFont(font);
        }
        y += kGap;
    }
}

bool ComparisonChart::event(QEvent* event)
{
    if (event->type() != QEvent::ToolTip)
        return QWidget::event(event);
    auto* help = static_cast<QHelpEvent*>(event);
    int top = 0;
    for (const planner::ComparedMeasure& measure : measures_) {
        const int height = height_of(measure);
        if (help->pos().y() >= top && help->pos().y() < top + height) {
            QToolTip::showText(help->globalPos(), measure.metric->meaning, this);
            return true;
        }
        top += height;
    }
    QToolTip::hideText();
    return true;
}

} // namespace retractor::ui
