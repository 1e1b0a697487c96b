#include "ui/workstation/palpation/strip_chart.h"

#include "ui/workstation/language/language.h"

#include <QPainter>
#include <QPainterPath>

#include <algorithm>
#include <array>
#include <cmath>

namespace retractor::ui {

namespace {

    constexpr double kMarginLeft = 62.0, kMarginRight = 14.0, kMarginTop = 22.0, kMarginBottom = 22.0; // pixels
    constexpr int kLines = 4; ///< across a plot
    const QColor kPressureColor(0xe0, 0x8a, 0x8a);

    /// The smallest 1, 2 or 5 times a power of ten that is not less than `value`.
    double round_up(double value)
    {
        const double decade = std::pow(10.0, std::floor(std::log10(value)));
        for (const double factor : { 1.0, 2.0, 5.0 })
            if (factor * decade >= value)
                return factor * decade;
        return 10.0 * decade;
    }

} // namespace

QColor finger_color(std::size_t finger)
{
    static const std::array<QColor, planner::kMostFingers> colors { QColor(0x5a, 0xb4, 0xff), QColor(0xff, 0xd2, 0x4a),
        QColor(0x7a, 0xe0, 0x7a), QColor(0xe0, 0x8a, 0xf0), QColor(0xff, 0x9a, 0x50), QColor(0xf0, 0xf0, 0xf0) };
    return colors[finger % colors.size()];
}

StripChart::StripChart(QWidget* parent)
    : QWidget(parent)
{
    setMinimumHeight(150);
    setAccessibleName("Pressure and force over time");
}

void StripChart::show_samples(
    std::vector<planner::StripSample> samples, std::size_t fingers, bool pulse, double force_gain)
{
    samples_ = std::move(samples);
    fingers_ = fingers;
    pulse_ = pulse;
    force_gain_ = force_gain;
    update();
}

void StripChart::draw_plot(QPainter& painter, const QRectF& box, const QString& title, double low, double high,
    const std::vector<Curve>& curves) const
{
    const double newest = samples_.empty() ? planner::PalpationFrame::kStripSeconds : samples_.back().time_s;
    const double span = planner::PalpationFrame::kStripSeconds;
    const auto x_of = [&](double time) { return box.right() - box.width() * (newest - time) / span; };
    const auto y_of = [&](double value) { return box.bottom() - box.height() * (value - low) / (high - low); };
    painter.setPen(QColor(0xe4, 0xe8, 0xeb));
    painter.drawText(QRectF(box.left(), box.top() - kMarginTop, box.width(), kMarginTop), Qt::AlignVCenter, title);
    for (int i = 0; i <= kLines; ++i) {
        const double value = low + (high - low) * i / kLines, y = y_of(value);
        painter.setPen(QPen(QColor(0x3b, 0x42, 0x49), 1.0));
        painter.drawLine(QPointF(box.left(), y), QPointF(box.right(), y));
        if (i % 2 != 0)
            continue;
        painter.setPen(QColor(0xa4, 0xad, 0xb5));
        painter.drawText(QRectF(0.0, y - 10.0, kMarginLeft - 6.0, 20.0), Qt::AlignRight | Qt::AlignVCenter,
            QString::number(value, 'g', 4));
    }
    painter.save();
    painter.setClipRect(box);
    for (const Curve& curve : curves) {
        QPainterPath path;
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            const QPointF at(x_of(samples_[i].time_s), y_of(curve.values[i]));
            if (i == 0)
                path.moveTo(at);
            else
                path.lineTo(at);
        }
        painter.setPen(QPen(curve.color, 1.8));
        painter.drawPath(path);
    }
    painter.restore();
}

void StripChart::paintEvent(QPaintEvent*)
{
    QPainter painter(this);
    painter.fillRect(rect(), QColor(0x1d, 0x21, 0x25));
    painter.setRenderHint(QPainter::Antialiasing);
    const int plots = pulse_ ? 2 : 1;
    const double across = width() - kMarginLeft - kMarginRight;
    const double height_each = (height() - kMarginBottom) / static_cast<double>(plots) - kMarginTop;
    double top = kMarginTop;
    if (pulse_) {
        Curve pressure { kPressureColor, {} };
        double low = 80.0, high = 120.0;
        for (const planner::StripSample& s : samples_) {
            pressure.values.push_back(s.pressure_mmHg);
            low = std::min(low, s.pressure_mmHg);
            high = std::max(high, s.pressure_mmHg);
        }
        constexpr double kStep = 20.0;
        draw_plot(painter, { kMarginLeft, top, across, height_each }, translated("Blood pressure, mmHg"),
            kStep * std::floor(low / kStep), kStep * std::ceil(high / kStep), { pressure });
        top += height_each + kMarginTop;
    }
    constexpr double kLeastForce = 0.1; // N
    double most = kLeastForce;
    std::vector<Curve> forces;
    for (std::size_t f = 0; f < fingers_; ++f) {
        forces.push_back({ finger_color(f), {} });
        for (const planner::StripSample& s : samples_) {
            forces.back().values.push_back(s.force[f]);
            most = std::max(most, s.force[f]);
        }
    }
    std::reverse(forces.begin(), forces.end()); // draws the first finger on top
    const QString gain = force_gain_ == 1.0
        ? QString()
        : QString("  (the hands feel this force times %1)").arg(force_gain_, 0, 'g', 3);
    draw_plot(painter, { kMarginLeft, top, across, height_each }, translated("Force on each finger, N") + gain, 0.0,
        round_up(most), forces);
    painter.setPen(QColor(0xa4, 0xad, 0xb5));
    const QRectF foot(kMarginLeft, height() - kMarginBottom, across, kMarginBottom);
    painter.drawText(foot, Qt::AlignLeft | Qt::AlignVCenter,
        translated(QString("%1 s ago").arg(planner::PalpationFrame::kStripSeconds)));
    painter.drawText(foot, Qt::AlignRight | Qt::AlignVCenter, translated("now"));
}

} // namespace retractor::ui
