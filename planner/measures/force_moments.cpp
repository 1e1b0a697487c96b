#include "planner/measures/force_moments.h"

#include "mesh/base/text_format.h"
#include "planner/measures/hook_opening.h"

#include <algorithm>

namespace retractor::planner {

namespace {

    /// The reason why the force does not relax at a fixed opening; empty where it does.
    std::string reason_against(const FieldMetrics& field)
    {
        if (field.retractor && field.retractor->asked_force_N)
            return "the rack pushes with a given force, so the wound opens farther with time instead";
        for (const HookForce& hook : field.hooks) {
            if (hook.pull.force_N)
                return "hook " + hook.name + " pulls with a given force, so the wound opens farther with time instead";
            if (hook.yielded)
                return "hook " + hook.name + " has yielded, so the wound opens farther with time instead";
            if (hook.pull.grip_N_per_mm)
                return "hook " + hook.name + " grips softly, so the lip follows it farther with time";
        }
        return {};
    }

} // namespace

std::vector<ForceStep> crank_steps(const OpeningProtocol& protocol, double opening_mm, double elastic_N)
{
    const int count = step_count(protocol, opening_mm);
    std::vector<ForceStep> steps;
    for (int n = 0; n < count; ++n)
        steps.push_back({ n * protocol.wait_s, elastic_N / count });
    return steps;
}

double last_turn_share(const Relaxation& relaxation, const OpeningProtocol& protocol, double opening_mm)
{
    return stepped_force(relaxation, crank_steps(protocol, opening_mm, 1.0), opening_time(protocol, opening_mm));
}

std::optional<ForceMoments> compute_force_moments(
    const FieldMetrics& field, const std::optional<OpeningProtocol>& protocol)
{
    const double opening_mm = hook_opening(field).reached_mm;
    if (field.hooks.empty() || !(field.hook_force_N > 0.0) || !(opening_mm > 0.0))
        return std::nullopt;
    ForceMoments moments;
    moments.message = reason_against(field);
    if (!moments.message.empty())
        return moments;
    const OpeningProtocol turned = protocol.value_or(OpeningProtocol {});
    const Relaxation& relaxation = chest_wall_relaxation();
    const double elastic_N = field.hook_force_N / last_turn_share(relaxation, OpeningProtocol {}, opening_mm);
    const std::vector<ForceStep> steps = crank_steps(turned, opening_mm, elastic_N);
    moments.opened_in_s = opening_time(turned, opening_mm);
    moments.hold_s = turned.hold_s;
    moments.peak_N = stepped_force(relaxation, steps, moments.opened_in_s);
    moments.held_N = stepped_force(relaxation, steps, moments.opened_in_s + moments.hold_s);
    // The force only falls while the wound is held, so no deviation takes it above the peak.
    moments.held_least_N = moments.held_N * std::max(0.0, 1.0 - held_deviation());
    moments.held_most_N = std::min(moments.held_N * (1.0 + held_deviation()), moments.peak_N);
    moments.protocol = opening_protocol_text(turned);
    moments.is_fast = is_fast(turned);
    moments.source = relaxation.source;
    return moments;
}

std::string force_moments_cell(const ForceMoments& moments)
{
    return formatted("%.0f N at the last turn, about %.0f N after ", moments.peak_N, moments.held_N)
        + time_text(moments.hold_s)
        + formatted(" (%.0f to %.0f N between animals)", moments.held_least_N, moments.held_most_N);
}

std::string force_moments_text(const FieldMetrics& field)
{
    if (!field.force_moments)
        return {};
    const ForceMoments& moments = *field.force_moments;
    if (!moments.message.empty())
        return "force after minutes not applicable: " + moments.message;
    return "force on a side: " + force_moments_cell(moments) + "; opened by " + moments.protocol + ", in "
        + time_text(moments.opened_in_s);
}

} // namespace retractor::planner
