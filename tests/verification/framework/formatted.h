#pragma once
// Numbers in the sentences of a row.

#include <array>
#include <cstdio>
#include <string>

namespace retractor {

/// As printf() has it, cut off at 255 characters.
template <class... Values> std::string formatted(const char* pattern, Values... values)
{
    std::array<char, 256> buffer {};
    (void)std::snprintf(buffer.data(), buffer.size(), pattern, values...);
    return buffer.data();
}

} // namespace retractor
