#include "ui/workstation/language/translated_page.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <string_view>
#include <utility>

namespace retractor::ui {

namespace {

    constexpr std::array<std::pair<const char*, const char*>, 8> kEntities { { { "&lt;", "<" }, { "&gt;", ">" },
        { "&quot;", "\"" }, { "&#39;", "'" }, { "&plusmn;", "\u00b1" }, { "&#177;", "\u00b1" }, { "&minus;", "\u2212" },
        { "&amp;", "&" } } }; // & last: it begins the others

    QString translated_words(const Phrasebook& book, const QString& english)
    {
        const QString begin = english.startsWith(": ") ? ": " : ""; // behind a name in bold letters
        const QString text = english.mid(begin.size());
        return begin + translated(book, text);
    }

    QString translated_text(const Phrasebook& book, std::string_view text)
    {
        QString plain = QString::fromUtf8(text.data(), static_cast<int>(text.size()));
        for (const auto& [entity, character] : kEntities)
            plain.replace(entity, character);
        const QString inner = plain.trimmed();
        const QString said = inner.isEmpty() ? inner : translated_words(book, inner.simplified());
        if (said == inner.simplified())
            return QString::fromUtf8(text.data(), static_cast<int>(text.size()));
        const int begin = plain.indexOf(inner);
        return plain.left(begin).toHtmlEscaped() + said.toHtmlEscaped()
            + plain.mid(begin + inner.size()).toHtmlEscaped();
    }

    /// Whether a tag begins an element whose content is no text for people.
    std::string_view end_of_raw_element(std::string_view tag)
    {
        for (const auto& [begin, end] :
            { std::pair<std::string_view, std::string_view> { "<script", "</script" }, { "<style", "</style" } })
            if (tag.starts_with(begin))
                return end;
        return {};
    }

} // namespace

std::string translated_page(const Phrasebook& book, const std::string& page, const std::string& language)
{
    constexpr std::string_view kEnglish = "lang=\"en\"";
    const std::string_view all = page;
    std::string out;
    out.reserve(page.size());
    for (std::size_t at = 0; at < all.size();) {
        if (all[at] != '<') {
            const std::size_t end = std::min(all.find('<', at), all.size());
            out += translated_text(book, all.substr(at, end - at)).toStdString();
            at = end;
            continue;
        }
        std::size_t end = all.find('>', at);
        end = end == std::string_view::npos ? all.size() : end + 1;
        const std::string_view tag = all.substr(at, end - at);
        if (const std::string_view closing = end_of_raw_element(tag); !closing.empty())
            end = std::min(all.find(closing, end), all.size());
        std::string kept(all.substr(at, end - at));
        if (const std::size_t lang = kept.find(kEnglish); tag.starts_with("<html") && lang != std::string::npos)
            kept.replace(lang, kEnglish.size(), "lang=\"" + language + "\"");
        out += kept;
        at = end;
    }
    return out;
}

void translate_page(const std::filesystem::path& file, const Phrasebook& book, const std::string& language)
{
    std::ifstream in(file, std::ios::binary);
    const std::string page { std::istreambuf_iterator<char>(in), {} };
    if (!in)
        throw IoError("cannot read the page", file.string());
    write_file_atomically(file, translated_page(book, page, language));
}

} // namespace retractor::ui
