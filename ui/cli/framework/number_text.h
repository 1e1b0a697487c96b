#pragma once
// Formats numbers as text for the command line.

#include <array>
#include <cstdio>
#include <string>

namespace retractor::ui::cli {

/// Writes one number with a printf format for a double, cut at 63 characters.
inline std::string number(const char* format, double value)
{
    std::array<char, 64> text {};
    std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

} // namespace retractor::ui::cli
