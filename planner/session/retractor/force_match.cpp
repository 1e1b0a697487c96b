#include "planner/session/retractor/force_match.h"

#include <algorithm>
#include <cmath>

namespace retractor::planner {

bool is_planned_retractor(const HookReport& report, const PlannedForce& plan)
{
    return report.retractors.size() == 1 && report.hooks.size() == 2 && report.retractors.front().kind == plan.retractor
        && std::ranges::all_of(
            report.hooks, [](const HookState& hook) { return hook.name.starts_with(kPlannedBlade); });
}

std::optional<double> force_match(const HookReport& report, const PlannedForce& plan)
{
    constexpr double kSameOpeningMm = 0.5, kAtRest = 0.1;
    if (!is_planned_retractor(report, plan) || !report.refusal.empty()
        || std::ranges::any_of(report.hooks, &HookState::yielded))
        return std::nullopt;
    const RetractorState& retractor = report.retractors.front();
    if (std::abs(retractor.opening_mm - plan.opening_mm) > kSameOpeningMm || retractor.imbalance > kAtRest
        || !(retractor.force_N > 0.0))
        return std::nullopt;
    const double factor = plan.force_N / retractor.force_N;
    return factor >= 1.0 / kMostMatched && factor <= kMostMatched ? std::optional(factor) : std::nullopt;
}

void multiply_forces(HookReport& report, double factor)
{
    report.force_factor = factor;
    for (HookState& hook : report.hooks)
        hook.force_N *= factor;
    for (double& side : report.side_N)
        side *= factor;
    for (RetractorState& retractor : report.retractors) {
        retractor.force_N *= factor;
        for (double& blade : retractor.blade_N)
            blade *= factor;
    }
}

} // namespace retractor::planner
