#pragma once
// Hook templates: sets of rigid patches along both lips of an approach. Units mm; frame patient LPS.
//
// 2, 4, 8: that many hooks (10 mm wide, through the wall), half of them on each lip, evenly over the middle 80 %.
//
// blade: a spreader, one blade per lip, as wide as half the incision but at most 60 mm.

#include "planner/case/case.h"

#include <string_view>
#include <vector>

namespace retractor::planner {

/// @param opening_mm distance between opposite hooks when open: each side moves half of it. 0 with a force to pull
/// with.
/// @param pull the same for all of them.
/// @throws InputError on an unknown template, a negative or NaN opening, an incision too short for the patches.
std::vector<HookSpec> make_hooks(
    const Approach& approach, std::string_view template_name, double opening_mm, const HookPull& pull = {});

/// Replaces the hooks of an approach of the case. @throws InputError as make_hooks and find_approach do.
void set_hooks(Case& planned_case, std::string_view approach_name, std::string_view template_name, double opening_mm,
    const HookPull& pull = {});

} // namespace retractor::planner
