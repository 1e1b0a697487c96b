#pragma once
// Changes the weights of the score; the comparison follows at once.

#include "planner/measures/ranking.h"

#include <QDialog>

#include <array>
#include <functional>

class QLabel;
class QSlider;

namespace retractor::ui {

class WeightsDialog : public QDialog {
public:
    WeightsDialog(const planner::Weights& weights, QWidget* parent);

    planner::Weights weights() const;
    /// Called with every change that leaves a weight above 0.
    std::function<void(const planner::Weights&)> on_change;

private:
    void show_weights(const planner::Weights& weights);
    void changed();

    std::array<QSlider*, planner::kCriteria> sliders_ {};
    std::array<QLabel*, planner::kCriteria> values_ {};
    QLabel* refusal_ = nullptr;
};

} // namespace retractor::ui
