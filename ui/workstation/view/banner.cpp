#include "ui/workstation/view/banner.h"

#include "ui/workstation/language/language.h"
#include "ui/workstation/view/controls.h"

#include <QHBoxLayout>
#include <QPushButton>

namespace retractor::ui {

Banner::Banner(const QString& colour)
    : text_(plain_label())
    , button_(new QPushButton)
{
    setAttribute(Qt::WA_StyledBackground);
    setStyleSheet("background: " + colour + "; color: white;");
    auto* row = new QHBoxLayout(this);
    row->addWidget(text_, 1);
    row->addWidget(button_);
    connect(button_, &QPushButton::clicked, this, [this] { on_button(); });
    hide();
}

void Banner::say(const QString& text, const QString& button)
{
    text_->setText(translated(text));
    button_->setText(translated(button));
    setVisible(!text.isEmpty());
}

} // namespace retractor::ui
