#pragma once
// Draws pressure and force over the last seconds.

#include "planner/session/palpation_session.h"

#include <QColor>
#include <QWidget>

#include <vector>

class QPainter;

namespace retractor::ui {

/// The colour of a finger, the same in the picture, the panel and the chart.
QColor finger_color(std::size_t finger);

class StripChart : public QWidget {
public:
    explicit StripChart(QWidget* parent = nullptr);

    /// @param pulse whether there is a pressure to draw
    void show_samples(std::vector<planner::StripSample> samples, std::size_t fingers, bool pulse, double force_gain);
    const std::vector<planner::StripSample>& samples() const { return samples_; }

protected:
    void paintEvent(QPaintEvent* event) override;

private:
    struct Curve {
        QColor color;
        std::vector<double> values; ///< one per sample
    };
    void draw_plot(QPainter& painter, const QRectF& box, const QString& title, double low, double high,
        const std::vector<Curve>& curves) const;

    std::vector<planner::StripSample> samples_;
    std::size_t fingers_ = 0;
    bool pulse_ = false;
    double force_gain_ = 1.0;
};

} // namespace retractor::ui
