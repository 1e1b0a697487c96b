#include "mesh/base/text_format.h"

#include <cstdarg>
#include <cstdio>

namespace retractor {

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
