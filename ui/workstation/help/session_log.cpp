#include "ui/workstation/help/session_log.h"

#include <QDateTime>
#include <QSysInfo>

#include <vtkVersion.h>

#include <cctype>
#include <regex>

namespace retractor::ui {

std::string without_paths(const std::string& text)
{
    // From a slash up to a space or a quote; "3/4" and "mm/s", in which a letter stands before the slash, stay.
    static const std::regex path(R"((~|\.{0,2})/[^\s"':,;]+)");
    std::string out;
    auto from = text.cbegin();
    for (std::sregex_iterator found(text.begin(), text.end(), path), end; found != end; ++found) {
        const auto at = text.cbegin() + found->position();
        const bool inside = at != text.cbegin() && std::isalnum(static_cast<unsigned char>(*(at - 1))) != 0;
        out.append(from, at);
        out += inside ? found->str() : "…";
        from = at + found->length();
    }
    out.append(from, text.cend());
    return out;
}

void SessionLog::add(const std::string& kind, const std::string& text)
{
    if (text.empty())
        return;
    lines_.push_back(QDateTime::currentDateTimeUtc().toString(Qt::ISODate).toStdString() + "  " + kind + ": "
        + without_paths(text));
    if (lines_.size() > kMostLines)
        lines_.pop_front();
}

std::string SessionLog::text(const std::string& renderer) const
{
    std::string text = std::string("Retractor " RETRACTOR_VERSION "\n") + "system: "
        + QSysInfo::prettyProductName().toStdString() + ", " + QSysInfo::kernelType().toStdString() + " "
        + QSysInfo::kernelVersion().toStdString() + ", " + QSysInfo::currentCpuArchitecture().toStdString() + "\n"
        + "Qt " + qVersion() + ", VTK " + vtkVersion::GetVTKVersion() + "\nOpenGL: " + renderer + "\n\n";
    for (const std::string& line : lines_)
        text += line + "\n";
    return text;
}

} // namespace retractor::ui
