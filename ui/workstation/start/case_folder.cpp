#include "ui/workstation/start/case_folder.h"

#include <QDir>

namespace retractor::ui {

std::filesystem::path free_case_folder(const std::string& name)
{
    const QString wanted = QDir::homePath() + "/Retractor/" + QString::fromStdString(name);
    QString folder = wanted;
    for (int number = 2; QDir(folder).exists(); ++number)
        folder = wanted + "-" + QString::number(number);
    return folder.toStdString();
}

} // namespace retractor::ui
