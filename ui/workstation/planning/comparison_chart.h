#pragma once
// Planned approaches beside each other: for each measure one bar per approach, with its error, and what leads beyond
// the error.

#include "planner/measures/comparison.h"

#include <QColor>
#include <QString>
#include <QWidget>

#include <cstddef>
#include <vector>

namespace retractor::ui {

/// Colour of the n-th planned approach, told apart by those who do not tell red from green (Okabe and Ito 2008).
QColor compared_color(std::size_t n);

class ComparisonChart : public QWidget {
public:
    explicit ComparisonChart(QWidget* parent = nullptr);

    /// @param places of the fields among all planned ones: they give letters and colours
    void show_fields(const std::vector<planner::FieldMetrics>& fields, std::vector<std::size_t> places);

protected:
    void paintEvent(QPaintEvent* event) override;
    bool event(QEvent* event) override;

private:
    std::vector<planner::ComparedMeasure> measures_;
    std::vector<std::size_t> places_;
};

} // namespace retractor::ui
