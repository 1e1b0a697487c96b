#pragma once
// Numbers as people read them, for messages and rationales.

#include "mesh/geometry.h"

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
    return "(" + in_words(point.x(), 1) + ", " + in_words(point.y(), 1) + ", " + in_words(point.z(), 1) + ") mm";
}

} // namespace retractor
