#include "planner/search/held_open.h"

#include "planner/approach/hook_mesh.h"
#include "planner/approach/retractors.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::planner {

OpenedBy opening_of(const FoundIncision& incision, const SearchRequest& request)
{
    constexpr double kSmallMm = 100.0;
    OpenedBy opened { .retractor = request.retractor, .opening_mm = incision.opening_mm };
    if (!request.hooks.empty())
        opened.hooks = request.hooks;
    else if (opened.retractor.empty())
        opened.retractor = incision.kind == FoundIncision::Kind::sternum ? "sternal"
            : incision.length_mm < kSmallMm                              ? "midcab"
                                                                         : "finochietto";
    return opened;
}

std::string other_retractor(const FoundIncision& incision, const SearchRequest& request)
{
    if (!request.hooks.empty() || !request.retractor.empty())
        return {};
    const std::string usual = opening_of(incision, request).retractor;
    const bool sternum = incision.kind == FoundIncision::Kind::sternum;
    const std::string other = usual == "finochietto" ? (sternum ? "sternal" : "midcab") : "finochietto";
    const RetractorKind& kind = find_retractor(built_in_retractors(), other);
    return kind.greatest_opening_mm >= incision.opening_mm && kind.blade_width_mm < incision.length_mm ? other : "";
}

ApertureWidth hole_width(const FoundIncision& incision, double wall_mm, const SearchRequest& request)
{
    constexpr double kLeastMm = 1.0; // on the skin, between blades that are hardly apart
    const OpenedBy opened = opening_of(incision, request);
    if (opened.retractor.empty())
        return { .skin_mm = opened.opening_mm, .inner_mm = opened.opening_mm };
    const RetractorKind& kind = find_retractor(built_in_retractors(), opened.retractor);
    const double turn = kind.play_deg * std::numbers::pi / 180.0;
    const double skin = std::max(kLeastMm, opened.opening_mm - 2.0 * kBladeThicknessMm);
    return { .skin_mm = skin, .inner_mm = skin - 2.0 * wall_mm * std::tan(turn) };
}

} // namespace retractor::planner
