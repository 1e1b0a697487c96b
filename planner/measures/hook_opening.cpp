#include "planner/measures/hook_opening.h"

#include "mesh/base/text_format.h"

#include <algorithm>
#include <map>

namespace retractor::planner {

HookOpening hook_opening(const FieldMetrics& field)
{
    struct Side {
        double asked = 0.0, moved = 0.0;
        int told = 0, hooks = 0;
    };
    Side sides[2];
    for (const HookForce& hook : field.hooks) {
        Side& side = sides[hook.side > 0 ? 0 : 1];
        side.moved += hook.moved_mm;
        ++side.hooks;
        if (hook.pull.force_N)
            continue;
        side.asked += hook.asked_mm;
        ++side.told;
    }
    HookOpening opening;
    if (field.retractor) { // the rack sets the distance of the blades, wherever the frame has drifted
        if (!field.retractor->asked_force_N)
            opening.asked_mm = field.retractor->opening_mm;
        opening.reached_mm = field.retractor->opening_mm;
        return opening;
    }
    for (const Side& side : sides) {
        if (side.told > 0)
            opening.asked_mm = opening.asked_mm.value_or(0.0) + side.asked / side.told;
        if (side.hooks > 0)
            opening.reached_mm += side.moved / side.hooks;
    }
    return opening;
}

std::string asked_text(const FieldMetrics& field)
{
    if (field.retractor && field.retractor->asked_force_N)
        return "the retractor opens with " + in_words(*field.retractor->asked_force_N, 1) + " N";
    std::string text;
    if (const auto asked = hook_opening(field).asked_mm)
        text = in_words(*asked, 1) + " mm";
    std::map<double, int> limits, forces; // number of hooks for each value
    for (const HookForce& hook : field.hooks) {
        if (hook.pull.force_limit_N)
            ++limits[*hook.pull.force_limit_N];
        if (hook.pull.force_N)
            ++forces[*hook.pull.force_N];
    }
    const auto add = [&](const std::string& words) { text += (text.empty() ? "" : ", ") + words; };
    const auto hooks = [](int count) { return std::to_string(count) + (count == 1 ? " hook" : " hooks"); };
    for (const auto& [limit, count] : limits)
        add((count == static_cast<int>(field.hooks.size()) ? std::string() : hooks(count) + " ") + "at most "
            + in_words(limit, 1) + (count == 1 ? " N" : " N per hook"));
    for (const auto& [force, count] : forces)
        add(hooks(count) + (count == 1 ? " pulls with " : " pull with ") + in_words(force, 1) + " N");
    return text.empty() ? "no hooks" : text;
}

bool has_limited_hooks(const FieldMetrics& field)
{
    return std::any_of(field.hooks.begin(), field.hooks.end(),
        [](const HookForce& hook) { return hook.pull.force_limit_N.has_value(); });
}

} // namespace retractor::planner
