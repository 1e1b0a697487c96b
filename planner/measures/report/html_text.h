#pragma once
// Text in HTML.

#include <string>
#include <string_view>

namespace retractor::planner {

/// The text with the characters replaced that mean something in HTML.
inline std::string escaped(std::string_view text)
{
    std::string out;
    for (const char c : text) {
        switch (c) {
        case '&':
            out += "&amp;";
            break;
        case '<':
            out += "&lt;";
            break;
        case '>':
            out += "&gt;";
            break;
        case '"':
            out += "&quot;";
            break;
        default:
            out += c;
        }
    }
    return out;
}

} // namespace retractor::planner
