#include "ui/workstation/planning/site_dialog.h"

#include "mesh/base/text_format.h"
#include "ui/workstation/language/language.h"
#include "ui/workstation/view/controls.h"

#include <QComboBox>
#include <QDialogButtonBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>

#include <cctype>
#include <string>
#include <string_view>

namespace retractor::ui {

namespace {

    constexpr double kLargestMm = 100.0; // half the width of a heart and more

    QString with_capital(std::string_view words)
    {
        QString text = QString::fromUtf8(words.data(), static_cast<int>(words.size()));
        text[0] = text[0].toUpper();
        return text;
    }

} // namespace

SiteDialog::SiteDialog(const planner::TargetSpec& proposed, bool met, QWidget* parent)
    : QDialog(parent)
    , proposed_(proposed)
{
    setWindowTitle("Target here");
    setMinimumWidth(400);
    const QString organ = QString::fromStdString(readable(proposed.label));
    auto* column = new QVBoxLayout(this);
    QLabel* const where = plain_label({});
    where->setText((met ? "The slices meet in the " : "The slices meet beside the ") + organ + ". What is done here?");
    column->addWidget(where);
    auto* form = new QFormLayout;
    form->setHorizontalSpacing(16);
    form->setVerticalSpacing(8);
    column->addLayout(form);
    site_ = new QComboBox;
    site_->setObjectName("site");
    for (const std::string_view site : planner::kSites)
        site_->addItem(with_capital(site), QString::fromUtf8(site.data(), static_cast<int>(site.size())));
    site_->addItem("The whole " + organ + " is the target", QString());
    radius_ = new QDoubleSpinBox;
    radius_->setObjectName("reach");
    radius_->setRange(1.0, kLargestMm);
    radius_->setDecimals(0);
    radius_->setSuffix(" mm");
    radius_->setValue(proposed.radius_mm);
    radius_->setToolTip("The surface of the " + organ + " up to this distance is the target.");
    form->addRow("Site", site_);
    form->addRow("Reaches", radius_);
    column->addStretch(1);
    auto* buttons = new QDialogButtonBox(QDialogButtonBox::Cancel);
    buttons->addButton("Take as target", QDialogButtonBox::AcceptRole)->setDefault(true);
    column->addWidget(buttons);
    connect(buttons, &QDialogButtonBox::accepted, this, &QDialog::accept);
    connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
    connect(site_, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
        [this] { radius_->setEnabled(!site_->currentData().toString().isEmpty()); });
    translate_texts(*this);
}

planner::TargetSpec SiteDialog::target() const
{
    const std::string site = site_->currentData().toString().toStdString();
    if (site.empty())
        return { .label = proposed_.label };
    planner::TargetSpec target = proposed_;
    target.site = site;
    target.radius_mm = radius_->value();
    return target;
}

} // namespace retractor::ui
