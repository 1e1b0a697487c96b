#include "planner/case/division.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/image/skeleton.h"

#include <algorithm>
#include <array>
#include <utility>

namespace retractor::planner {

namespace {

    constexpr std::array<std::pair<DivisionExtent, std::string_view>, 5> kExtents { {
        { DivisionExtent::skin, "skin" },
        { DivisionExtent::full, "full" },
        { DivisionExtent::sternum_right, "sternum-right" },
        { DivisionExtent::sternum_left, "sternum-left" },
        { DivisionExtent::sternum_across, "sternum-across" },
    } };

    /// Longer than any intercostal space from spine to sternum; more is a mistaken unit.
    constexpr double kLongestSpaceMm = 500.0;

    /// Whether the label holds nothing but what a division severs.
    bool is_intercostal(const mesh::LabelInfo& info)
    {
        return info.material == "intercostal" || info.name.find("intercostal") != std::string::npos
            || info.name.find("pleura") != std::string::npos;
    }

    void check_distance(const std::optional<double>& distance, DivisionExtent extent, const std::string& where)
    {
        if (!distance)
            return;
        if (extent != DivisionExtent::full)
            throw InputError("a distance beyond the skin needs the extent \"full\": remove one", where);
        if (!(*distance >= 0.0 && *distance <= kLongestSpaceMm)) // refuses NaN too
            throw InputError(formatted("must be between 0 and %.0f mm, got %g", kLongestSpaceMm, *distance), where);
    }

} // namespace

bool divides_sternum(DivisionExtent extent)
{
    return extent == DivisionExtent::sternum_right || extent == DivisionExtent::sternum_left
        || extent == DivisionExtent::sternum_across;
}

std::string_view to_string(StrokeWay way)
{
    switch (way) {
    case StrokeWay::forwards:
        return "forwards";
    case StrokeWay::backwards:
        return "backwards";
    case StrokeWay::right:
        return "right";
    case StrokeWay::left:
        return "left";
    }
    return {};
}

std::string_view to_string(DivisionExtent extent)
{
    return std::find_if(kExtents.begin(), kExtents.end(), [&](const auto& e) { return e.first == extent; })->second;
}

std::optional<DivisionExtent> division_extent_from_string(std::string_view text)
{
    for (const auto& [extent, name] : kExtents)
        if (name == text)
            return extent;
    return std::nullopt;
}

DividedLabels divided_labels(const mesh::LabelTable& table)
{
    DividedLabels own { .has_own = true }, soft;
    for (const mesh::LabelInfo& info : table) {
        if (!mesh::is_wall(info) || mesh::is_skeleton(info) || info.material == "skin")
            continue;
        DividedLabels& labels = is_intercostal(info) ? own : soft;
        labels.ids.push_back(info.id);
        labels.names.push_back(info.name);
    }
    return own.ids.empty() ? soft : own;
}

mesh::Blade blade_of(const DivisionStroke& stroke)
{
    // The line lies in the chest already, so that nothing further inwards is searched for tissue.
    return { .line = stroke.line, .directions = stroke.directions, .depth_mm = stroke.depth_mm, .above_mm = 0.0 };
}

void check_division(const Division& division, const std::string& pointer)
{
    check_distance(division.forwards_mm, division.extent, pointer + "/forwards_mm");
    check_distance(division.backwards_mm, division.extent, pointer + "/backwards_mm");
}

} // namespace retractor::planner
