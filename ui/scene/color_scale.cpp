#include "ui/scene/color_scale.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace retractor::ui {

namespace {

    /// Equal steps of viridis.
    constexpr std::array<Color, 5> kScale { {
        { 0.27, 0.00, 0.33 },
        { 0.23, 0.32, 0.55 },
        { 0.13, 0.57, 0.55 },
        { 0.37, 0.79, 0.38 },
        { 0.99, 0.91, 0.14 },
    } };

} // namespace

Color scale_color(double share)
{
    const double at = std::clamp(share, 0.0, 1.0) * (kScale.size() - 1);
    const std::size_t low = std::min(static_cast<std::size_t>(at), kScale.size() - 2);
    const double part = at - static_cast<double>(low);
    const Color &a = kScale.at(low), &b = kScale.at(low + 1);
    return { a.r + part * (b.r - a.r), a.g + part * (b.g - a.g), a.b + part * (b.b - a.b) };
}

std::size_t ColorClasses::of(double number) const
{
    RETRACTOR_ASSERT(std::isfinite(number));
    return static_cast<std::size_t>(std::upper_bound(limits.begin(), limits.end(), number) - limits.begin());
}

Color ColorClasses::color(std::size_t index) const
{
    RETRACTOR_ASSERT(index < count());
    const double share = limits.empty() ? 0.5 : static_cast<double>(index) / static_cast<double>(limits.size());
    return scale_color(low_is_bright ? 1.0 - share : share);
}

std::string ColorClasses::words(std::size_t index, int digits) const
{
    RETRACTOR_ASSERT(index < count());
    if (index == 0)
        return "below " + in_words(limits.front(), digits);
    if (index == limits.size())
        return in_words(limits.back(), digits) + " or more";
    return in_words(limits[index - 1], digits) + " to " + in_words(limits[index], digits);
}

std::vector<LegendLine> ColorClasses::legend(const std::string& unit, int digits) const
{
    std::vector<LegendLine> lines;
    for (std::size_t index = count(); index-- > 0;)
        lines.push_back({ words(index, digits) + " " + unit, " ", color(index) });
    return lines;
}

} // namespace retractor::ui
