#pragma once
// Dark and neutral: the tissue colours of the picture are judged against it.

class QApplication;

namespace retractor {

void apply_theme(QApplication& application);

} // namespace retractor
