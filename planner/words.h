#pragma once
// Numbers as people read them, for messages and rationales.

#include "mesh/geometry.h"

#include <algorithm>
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

} // namespace retractor
