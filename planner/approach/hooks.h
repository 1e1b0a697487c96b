#pragma once
// Hook templates: sets of rigid patches along both lips of an approach. Units mm; frame patient LPS.
//
// - 2, 4 and 8 are the numbers of hooks. A hook is 10 mm wide and goes through the wall. Half of the hooks hold each
//   lip, evenly along the middle 80 %.
// - blade is a spreader: one blade per lip, half as wide as the incision is long, at most 60 mm.

#include "planner/case/case.h"

#include <string_view>
#include <vector>

namespace retractor::planner {

/// Hooks stand in this middle part of the incision, because its ends hardly open.
inline constexpr double kHeldShare = 0.8;

/// @param opening_mm distance that opposite hooks open; each side moves half of this distance; 0 for hooks that pull
/// with a force
/// @param pull force, limit and grip of every hook
/// @throws InputError on an unknown template, a negative or NaN opening, or an incision too short for the patches
std::vector<HookSpec> make_hooks(
    const Approach& approach, std::string_view template_name, double opening_mm, const HookPull& pull = {});

/// One rigid patch per lip, side +1 first; the two face each other. They are named by their pull, such as left_blade
/// and right_blade (blade_name()), and do not move yet.
/// @param along_mm middle of the patches along the incision
/// @param largest_depth_mm depth below the skin that the patches reach at most
/// @throws InputError where the wall is too thin for a patch
std::vector<HookSpec> make_blades(const Approach& approach, double along_mm, double width_mm, double largest_depth_mm);

/// Depth below the skin at which a blade has passed the wall where it is thickest under the blade, mm: all bone beside
/// the cut lies above it. Places where the cut ends within the wall do not count, unless it does everywhere.
/// @param along_mm middle of the blade along the incision
double depth_through_wall(const Approach& approach, double along_mm, double width_mm);

/// Replaces the hooks or the retractor of an approach of the case. @throws InputError as make_hooks() and
/// find_approach() do
void set_hooks(Case& planned_case, std::string_view approach_name, std::string_view template_name, double opening_mm,
    const HookPull& pull = {});

} // namespace retractor::planner
