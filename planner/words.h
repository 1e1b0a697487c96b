#pragma once
// Numbers as people read them, for messages and rationales.

#include "mesh/geometry.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

namespace retractor {

inline std::string in_words(double value, int digits = 0)
{
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

inline std::string in_words(const Vec3& point)
{
    char text[128];
    std::snprintf(text, sizeof text, "(%.1f, %.1f, %.1f) mm", point.x(), point.y(), point.z());
    return text;
}

/// Adds a remark to a message, unless it is empty.
inline void remark(std::string& message, const std::string& text)
{
    if (!text.empty())
        message += (message.empty() ? "" : "; ") + text;
}

/// A label's name without underscores.
inline std::string readable(std::string label)
{
    std::replace(label.begin(), label.end(), '_', ' ');
    return label;
}

/// "966.2 cm3"; what is less than 0.1 cm3 in mm3.
inline std::string volume_text(double volume_mm3)
{
    constexpr double kLeastCm3 = 0.1, kLeastMm3 = 1.0;
    const double cm3 = 1e-3 * volume_mm3;
    std::array<char, 64> text {};
    if (cm3 >= kLeastCm3)
        std::snprintf(text.data(), text.size(), "%.1f cm3", cm3);
    else
        std::snprintf(text.data(), text.size(), volume_mm3 >= kLeastMm3 ? "%.0f mm3" : "%.2g mm3", volume_mm3);
    return text.data();
}

} // namespace retractor
