#pragma once
// Matches the forces of a retractor that is opened by hand to those of the plan of the same wound.
//
// The answer under a hand is quick: four-node elements, blades that push from the skin to the bone, linear tissue far
// from the wound. Its forces are off by up to three times, to either side, and a plan of the same wound knows better.
// Units mm, N.

#include "planner/session/wound_hooks.h"

#include <optional>
#include <string>
#include <string_view>

namespace retractor::planner {

/// What the plan of an approach says of its retractor.
struct PlannedForce {
    std::string retractor; ///< as RetractorState::kind
    double opening_mm = 0.0; ///< of its arms
    double force_N = 0.0; ///< on each blade
    double low_N = 0.0, high_N = 0.0; ///< interval of the force (ForceInterval)
    double seen_share = 0.0; ///< of the target, from the plan's best eye
    std::string objections {}; ///< what the plan says against this opening, in sentences; empty: nothing
    bool operator==(const PlannedForce&) const = default;
};

/// Begin of the names of the blades that the approach sets.
inline constexpr std::string_view kPlannedBlade = "planned ";

/// Beyond this factor, either way, something else is wrong, and forces are not matched.
inline constexpr double kMostMatched = 5.0;

/// Whether the hooks are the retractor of the approach, by its kind and the names of its blades.
bool is_planned_retractor(const HookReport& report, const PlannedForce& plan);

/// By what the forces must be multiplied to be those of the plan at the plan's opening; nothing where the retractor is
/// not as planned, not at rest, slips or is refused, and beyond kMostMatched.
std::optional<double> force_match(const HookReport& report, const PlannedForce& plan);

/// Multiplies all forces of the report, and records the factor in it.
void multiply_forces(HookReport& report, double factor);

} // namespace retractor::planner
