#pragma once
// What the controls of all panels share: keys belong to the picture, so that controls take no keyboard focus.

#include <QLabel>
#include <QString>

namespace retractor::ui {

/// The control, with a tool tip and without keyboard focus.
template <class Control> Control* unfocused(Control* control, const QString& tip = {})
{
    control->setToolTip(tip);
    control->setFocusPolicy(Qt::NoFocus);
    return control;
}

/// A label of plain text in several lines.
inline QLabel* plain_label(const QString& style = {})
{
    auto* label = new QLabel;
    label->setTextFormat(Qt::PlainText);
    label->setWordWrap(true);
    label->setStyleSheet(style);
    return label;
}

} // namespace retractor::ui
