#include "datasets/dicom/patient_words.h"

#include <algorithm>
#include <cstdint>
#include <string_view>

namespace retractor::datasets {

namespace {

    /// The lower-case form of a code point that UTF-8 writes in two bytes. The result also takes two bytes.
    std::uint32_t lower(std::uint32_t c)
    {
        const auto within = [c](std::uint32_t first, std::uint32_t last) { return c >= first && c <= last; };
        if (within(0x00C0, 0x00DE) && c != 0x00D7) // Latin-1
            return c + 0x20;
        if (c == 0x0178)
            return 0x00FF;
        if (within(0x0100, 0x0137) || within(0x014A, 0x0177) || within(0x01DE, 0x01EF) || within(0x01F8, 0x0233)
            || within(0x0460, 0x0481) || within(0x048A, 0x04BF) || within(0x04D0, 0x052F))
            return c | 1U; // the capital has the even code point
        if (within(0x0139, 0x0148) || within(0x0179, 0x017E) || within(0x01CD, 0x01DC) || within(0x04C1, 0x04CE))
            return c + (c & 1U); // the capital has the odd code point
        if (c == 0x01A0 || c == 0x01AF) // O and U with horn (Vietnamese)
            return c + 1;
        if (within(0x0391, 0x03AB) || within(0x0410, 0x042F))
            return c + 0x20;
        if (within(0x0400, 0x040F))
            return c + 0x50;
        return c;
    }

    bool continues(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

    /// True for a letter: ASCII, or an alphabet that UTF-8 writes in two bytes. Punctuation and scripts without spaces
    /// between words do not count.
    bool letter_at(const std::string& text, std::size_t at)
    {
        if (at >= text.size())
            return false;
        const auto c = static_cast<unsigned char>(text[at]);
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= 0xC3 && c <= 0xDF);
    }

    bool letter_before(const std::string& text, std::size_t at)
    {
        if (at == 0)
            return false;
        std::size_t start = at - 1;
        while (start > 0 && continues(text[start]))
            --start;
        return letter_at(text, start);
    }

} // namespace

std::vector<std::string> name_parts(const std::string& name)
{
    std::vector<std::string> parts;
    std::string part;
    for (const char c : name + "^") {
        if (std::string_view("^= ,;.").find(c) == std::string_view::npos) {
            part += c;
            continue;
        }
        if (!part.empty() && std::find(parts.begin(), parts.end(), part) == parts.end())
            parts.push_back(part);
        part.clear();
    }
    return parts;
}

std::string fold_case(std::string text)
{
    for (std::size_t at = 0; at < text.size(); ++at) {
        const auto c = static_cast<unsigned char>(text[at]);
        if (c >= 'A' && c <= 'Z')
            text[at] = static_cast<char>(c + ('a' - 'A'));
        if (c < 0xC2 || c > 0xDF || at + 1 >= text.size() || !continues(text[at + 1]))
            continue;
        const std::uint32_t small = lower((c & 0x1FU) << 6U | (static_cast<unsigned char>(text[at + 1]) & 0x3FU));
        text[at] = static_cast<char>(0xC0U | small >> 6U);
        text[++at] = static_cast<char>(0x80U | (small & 0x3FU));
    }
    return text;
}

std::vector<std::size_t> whole_words(const std::string& text, const std::string& word)
{
    std::vector<std::size_t> places;
    if (word.empty())
        return places;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
        if (!letter_before(text, at) && !letter_at(text, at + word.size()))
            places.push_back(at);
    return places;
}

std::vector<std::string> telling_parts(const std::string& text, const std::string& name)
{
    const std::string folded = fold_case(text);
    std::vector<std::string> there;
    for (const std::string& part : name_parts(fold_case(name)))
        if (!whole_words(folded, part).empty())
            there.push_back(part);
    if (there.size() < 2)
        std::erase_if(there, [](const std::string& part) { return part.size() < kShortestTelling; });
    return there;
}

} // namespace retractor::datasets
