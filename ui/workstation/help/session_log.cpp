#include "ui/workstation/help/session_log.h"

#include <QDateTime>
#include <QSysInfo>

#include <algorithm>
#include <array>
#include <cctype>
#include <regex>

namespace retractor::ui {

namespace {

    /// Begins of places in a case file.
    constexpr std::array kPlaces { "/approaches", "/labels", "/materials", "/solution", "/supports", "/pressures",
        "/patient", "/ct", "/sizing", "/views" };

    /// Names that are in every path and name nobody.
    bool is_common(const std::string& name)
    {
        constexpr std::array kCommon { "home", "data", "tmp", "root", "case.json", "labels.nrrd", "ct.nrrd", "Desktop",
            "Documents", "Retractor" };
        constexpr std::size_t kShortest = 3; // shorter words would hide parts of others
        return name.size() < kShortest
            || std::any_of(kCommon.begin(), kCommon.end(), [&](const char* common) { return name == common; });
    }

    void replace_all(std::string& text, const std::string& word, const std::string& by)
    {
        for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + by.size()))
            text.replace(at, word.size(), by);
    }

} // namespace

std::string without_paths(const std::string& text)
{
    // From a slash up to a space or a quote; "3/4" and "mm/s", in which a letter stands before the slash, stay.
    static const std::regex path(R"((~|\.{0,2})/[^\s"':,;]+)");
    std::string out;
    auto from = text.cbegin();
    for (std::sregex_iterator found(text.begin(), text.end(), path), end; found != end; ++found) {
        const auto at = text.cbegin() + found->position();
        const std::string match = found->str();
        const bool inside = at != text.cbegin() && std::isalnum(static_cast<unsigned char>(*(at - 1))) != 0;
        const bool place
            = std::any_of(kPlaces.begin(), kPlaces.end(), [&](const char* begin) { return match.starts_with(begin); });
        out.append(from, at);
        out += inside || place ? match : "…";
        from = at + found->length();
    }
    out.append(from, text.cend());
    return out;
}

void SessionLog::hide(const std::filesystem::path& path)
{
    hidden_.insert(path.string());
    for (const std::filesystem::path& part : path)
        if (const std::string name = part.string(); !is_common(name) && name != "/")
            hidden_.insert(name);
    if (const std::string stem = path.stem().string(); !is_common(stem) && stem != "case")
        hidden_.insert(stem);
}

void SessionLog::add(const std::string& kind, const std::string& text)
{
    if (text.empty())
        return;
    std::string line = text;
    for (const std::string& word : hidden_)
        replace_all(line, word, "…");
    lines_.push_back(
        QDateTime::currentDateTimeUtc().toString(Qt::ISODate).toStdString() + "  " + kind + ": " + without_paths(line));
    if (lines_.size() > kMostLines)
        lines_.pop_front();
}

std::string SessionLog::text(const std::string& renderer) const
{
    std::string text = std::string("Retractor " RETRACTOR_VERSION "\n")
        + "system: " + QSysInfo::prettyProductName().toStdString() + ", " + QSysInfo::kernelType().toStdString() + " "
        + QSysInfo::kernelVersion().toStdString() + ", " + QSysInfo::currentCpuArchitecture().toStdString() + "\n"
        + "Qt " + qVersion() + ", VTK " + RETRACTOR_VTK_VERSION + "\nOpenGL: " + renderer + "\n\n";
    for (const std::string& line : lines_)
        text += line + "\n";
    return text;
}

} // namespace retractor::ui
