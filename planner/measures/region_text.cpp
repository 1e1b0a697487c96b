#include "planner/measures/region_text.h"

#include "mesh/base/text_format.h"
#include "planner/measures/bones/bone_limits.h"

#include <array>
#include <cstddef>

namespace retractor::planner {

namespace {

    /// "0.8 mm", "33 mm".
    std::string short_mm(double mm)
    {
        constexpr double kWithoutFraction = 10.0;
        return formatted(mm < kWithoutFraction ? "%.1f mm" : "%.0f mm", mm);
    }

    std::string size_text(const RegionMetrics& region)
    {
        if (region.ended_by == RegionEnd::whole || region.region_mm == 0.0)
            return "The model holds the whole wall in the image.";
        return formatted("The model holds the wall within %.0f mm of the incision", region.region_mm)
            + (region.ended_by == RegionEnd::given ? " (given)." : ".");
    }

    std::string end_text(const RegionMetrics& region)
    {
        switch (region.ended_by) {
        case RegionEnd::memory:
            return " A larger region needs more memory than there is.";
        case RegionEnd::failure:
            return " A larger region gave no answer: " + region.message + ".";
        default:
            return {};
        }
    }

    std::string rim_text(const RegionMetrics& region)
    {
        std::string text;
        if (!region.rim_place.empty())
            text = " Where it ends, tissue moves by up to " + short_mm(region.rim_motion_mm) + " (" + region.rim_place
                + ").";
        if (region.image_end_motion_mm > kStillRimMm)
            text += " Where the image ends, tissue moves by up to " + short_mm(region.image_end_motion_mm)
                + ": what holds it beyond the image is not known.";
        return text;
    }

} // namespace

std::string_view to_string(RegionEnd end)
{
    constexpr std::array<std::string_view, 6> kNames { "not_searched", "given", "still", "whole", "memory", "failure" };
    return kNames.at(static_cast<std::size_t>(end)); // in the order of RegionEnd
}

std::string region_text(const FieldMetrics& field)
{
    const RegionMetrics& region = field.region;
    std::string text = size_text(region) + end_text(region) + rim_text(region);
    if (is_region_too_small(field) && !region.force_change)
        text += " No bar contains the force that the wall beyond would add: on phantoms the force with the whole wall "
                "was up to twice as large.";
    if (region.force_change)
        text += *region.force_change > 1.0
            ? " By drafts, the wall beyond changes the force more than twofold."
            : formatted(" By drafts, the wall beyond changes the force by %.1f %%.", 100.0 * *region.force_change);
    return text;
}

bool is_region_too_small(const FieldMetrics& field)
{
    return field.region.rim_motion_mm > kStillRimMm || !field.region.piercing.empty();
}

std::string piercing_text(const FieldMetrics& field)
{
    if (field.region.piercing.empty())
        return {};
    std::vector<std::string> bones;
    for (const PiercingBone& bone : field.region.piercing)
        bones.push_back(bone_in_words(bone.name) + formatted(" by %.0f mm", bone.out_mm));
    return "not usable: these numbers are not to be believed: bones come out through the skin, " + joined(bones)
        + ", because the tissue round them is not in the model; "
        + (field.solution.draft ? "a draft does not look for the region: plan in full"
                                : "plan with a larger region, or let the plan find it (leave region_mm out)");
}

} // namespace retractor::planner
