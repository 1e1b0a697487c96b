#include "planner/measures/rupture.h"

#include "mesh/base/text_format.h"
#include "planner/measures/hook_opening.h"

#include <algorithm>

namespace retractor::planner {

namespace {

    /// The larger of the planned force and the force at the last turn.
    double largest_force(const FieldMetrics& field)
    {
        return field.force_moments ? std::max(field.hook_force_N, field.force_moments->peak_N) : field.hook_force_N;
    }

    /// Whether the halves of the sternum are parted, not ribs.
    bool parts_the_sternum(const FieldMetrics& field)
    {
        const auto is_sternum = [](const std::string& bone) { return bone.starts_with("sternum"); };
        return !field.hooks.empty() && std::ranges::all_of(field.hooks, [&](const HookForce& hook) {
            return std::ranges::any_of(hook.bears_on, is_sternum);
        });
    }

} // namespace

bool may_rupture(const FieldMetrics& field)
{
    constexpr double kShownMm = 0.05; // what is shown as 30.0 mm is not beyond 30 mm
    return !parts_the_sternum(field) && hook_opening(field).reached_mm > kRuptureOpeningMm + kShownMm
        && largest_force(field) > kRuptureForceN;
}

std::string rupture_text(const FieldMetrics& field)
{
    if (!may_rupture(field))
        return {};
    return formatted(
        "%.1f mm and %.0f N: beyond %.0f mm and %.1f N tissue ruptured in half of 24 retractions with a rib "
        "spreader (Chanoit 2019)",
        hook_opening(field).reached_mm, largest_force(field), kRuptureOpeningMm, kRuptureForceN);
}

std::string fast_opening_text(const FieldMetrics& field)
{
    if (!field.force_moments || !field.force_moments->is_fast || parts_the_sternum(field))
        return {};
    return field.force_moments->protocol
        + ": nearly all retractions faster than half a turn in 10 s ruptured tissue (Chanoit 2019)";
}

} // namespace retractor::planner
