#include "mesh/base/text_format.h"

#include <algorithm>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <ranges>

namespace retractor {

namespace {

    bool is_side(std::string_view word) { return word == "left" || word == "right"; }

    bool is_number(std::string_view word)
    {
        return !word.empty() && word.find_first_not_of("0123456789") == std::string_view::npos;
    }

    /// "left rib 5" for "rib_left_5".
    std::string name_in_words(std::string_view name)
    {
        std::vector<std::string> words;
        for (const auto& word : name | std::views::split('_'))
            words.emplace_back(word.begin(), word.end());
        // Behind the side of a name stand its number or its state at most: "rib_left_5", "lung_left_deflated".
        for (std::size_t side = words.size(); side-- > 1;)
            if (is_side(words[side])) {
                const bool ends = side + 1 == words.size();
                if (ends || is_number(words[side + 1]) || words[side + 1] == "deflated" || words[side + 1].empty())
                    std::rotate(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(side),
                        words.begin() + static_cast<std::ptrdiff_t>(side) + 1);
                break;
            }
        std::string text;
        for (const std::string& word : words)
            text += (&word == words.data() ? "" : " ") + word;
        return text;
    }

} // namespace

std::string in_words(double value, int digits)
{
    std::string text = formatted("%.*f", digits, value);
    if (text.front() == '-' && text.find_first_not_of("-0.") == std::string::npos)
        text.erase(0, 1);
    return text;
}

std::string readable(std::string_view label)
{
    constexpr std::string_view kBetweenNames = " ,;()";
    std::string text;
    while (!label.empty()) {
        const std::size_t between = std::min(label.find_first_of(kBetweenNames), label.size());
        text += name_in_words(label.substr(0, between));
        if (between < label.size())
            text += label[between];
        label.remove_prefix(std::min(between + 1, label.size()));
    }
    return text;
}

std::string formatted(const char* format, ...)
{
    std::va_list values, again;
    va_start(values, format);
    va_copy(again, values);
    const int length = std::vsnprintf(nullptr, 0, format, values);
    va_end(values);
    std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
    std::vsnprintf(text.data(), text.size() + 1, format, again); // overwrites the string's terminator with a terminator
    va_end(again);
    return text;
}

} // namespace retractor
