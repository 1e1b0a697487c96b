#include "ui/workstation/planning/weights_dialog.h"

#include "ui/workstation/language/language.h"
#include "ui/workstation/view/controls.h"
#include "ui/workstation/view/theme.h"

#include <QDialogButtonBox>
#include <QGridLayout>
#include <QPushButton>
#include <QSlider>
#include <QVBoxLayout>

#include <algorithm>
#include <cmath>

namespace retractor::ui {

namespace {

    constexpr int kLargestWeight = 5, kStepsPerUnit = 2;

} // namespace

WeightsDialog::WeightsDialog(const planner::Weights& weights, QWidget* parent)
    : QDialog(parent)
{
    setObjectName("weights");
    setWindowTitle("Weights of the score");
    auto* column = new QVBoxLayout(this);
    auto* head = plain_label(kFaint);
    head->setText("How much each criterion counts in the score. 0 leaves it out.");
    column->addWidget(head);
    auto* grid = new QGridLayout;
    grid->setHorizontalSpacing(16);
    grid->setVerticalSpacing(8);
    for (std::size_t n = 0; n < planner::kCriteria; ++n) {
        const planner::Criterion& criterion = planner::criteria()[n];
        const int row = static_cast<int>(n);
        auto* name = new QLabel(criterion.caption);
        auto* slider = new QSlider(Qt::Horizontal);
        slider->setObjectName(criterion.key);
        slider->setRange(0, kLargestWeight * kStepsPerUnit);
        slider->setMinimumWidth(200);
        slider->setAccessibleName(criterion.caption);
        auto* value = new QLabel;
        value->setMinimumWidth(32);
        for (QWidget* widget : { static_cast<QWidget*>(name), static_cast<QWidget*>(slider) })
            widget->setToolTip(criterion.meaning);
        grid->addWidget(name, row, 0);
        grid->addWidget(slider, row, 1);
        grid->addWidget(value, row, 2);
        sliders_.at(n) = slider;
        values_.at(n) = value;
    }
    column->addLayout(grid);
    refusal_ = plain_label("color: #f0a35e;");
    column->addWidget(refusal_);
    auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close);
    QPushButton* const usual = buttons->addButton("Defaults", QDialogButtonBox::ResetRole);
    column->addWidget(buttons);
    show_weights(weights);
    for (QSlider* slider : sliders_)
        connect(slider, &QSlider::valueChanged, this, [this] { changed(); });
    connect(usual, &QPushButton::clicked, this, [this] { show_weights(planner::default_weights()); });
    connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
    translate_texts(*this);
}

void WeightsDialog::show_weights(const planner::Weights& weights)
{
    for (std::size_t n = 0; n < weights.size(); ++n) {
        sliders_.at(n)->setValue(static_cast<int>(std::lround(kStepsPerUnit * weights.at(n))));
        values_.at(n)->setText(QString::number(this->weights().at(n)));
    }
}

planner::Weights WeightsDialog::weights() const
{
    planner::Weights weights {};
    for (std::size_t n = 0; n < weights.size(); ++n)
        weights.at(n) = sliders_.at(n)->value() / static_cast<double>(kStepsPerUnit);
    return weights;
}

void WeightsDialog::changed()
{
    const planner::Weights now = weights();
    for (std::size_t n = 0; n < now.size(); ++n)
        values_.at(n)->setText(QString::number(now.at(n)));
    const bool any = std::ranges::any_of(now, [](double weight) { return weight > 0.0; });
    refusal_->setText(any ? QString() : translated("All weights are 0: nothing would count. The weights before stay."));
    if (any && on_change)
        on_change(now);
}

} // namespace retractor::ui
