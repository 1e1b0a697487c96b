#pragma once
// Numbers and names as people read them, for messages and rationales.

#include "mesh/base/geometry.h"

#include <string>
#include <string_view>
#include <vector>

namespace retractor {

/// The text that printf() would write, of any length.
[[gnu::format(printf, 1, 2)]] std::string formatted(const char* format, ...);

/// The number with this many digits behind the point; what rounds to zero has no sign.
std::string in_words(double value, int digits = 0);

inline std::string in_words(const Vec3& point)
{
    return formatted("(%.1f, %.1f, %.1f) mm", point.x(), point.y(), point.z());
}

/// The words with ", " between them.
inline std::string joined(const std::vector<std::string>& words)
{
    std::string text;
    for (const std::string& word : words)
        text += (text.empty() ? "" : ", ") + word;
    return text;
}

/// Appends a remark to a message, after "; ". Does nothing for an empty remark.
inline void remark(std::string& message, const std::string& text)
{
    if (!text.empty())
        message += (message.empty() ? "" : "; ") + text;
}

/// A label's name in words, the side first: "fat and muscle" for "fat_and_muscle", "left lung" for "lung_left", "left
/// rib 5" for "rib_left_5". Several names are changed one by one: "left lung, heart" for "lung_left, heart".
std::string readable(std::string_view label);

/// A volume such as "966.2 cm3"; in mm3 below 0.1 cm3.
inline std::string volume_text(double volume_mm3)
{
    constexpr double kLeastCm3 = 0.1, kLeastMm3 = 1.0;
    const double cm3 = 1e-3 * volume_mm3;
    if (cm3 >= kLeastCm3)
        return formatted("%.1f cm3", cm3);
    return formatted(volume_mm3 >= kLeastMm3 ? "%.0f mm3" : "%.2g mm3", volume_mm3);
}

} // namespace retractor
