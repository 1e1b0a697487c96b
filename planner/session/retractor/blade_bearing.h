#pragma once
// Where the blade of a retractor bears on a lip that was cut by hand, and how it stands there. The blade hangs on its
// arm at the level of the skin and turns freely about it within its play. All that it bears on lies below the arm, so
// it turns with its end into the wound until its play ends, or until the ends of the two blades meet. What lies deep
// therefore moves less than the arms do. Units mm, rad; frame patient LPS.

#include "mesh/cutting/cut_session.h"
#include "planner/session/hook_placement.h"

#include <array>
#include <span>

namespace retractor::planner {

/// Leaves to a blade the nodes of the lip from the skin to the level where it bears: where the bone behind the lip lies
/// nearest to the blade's middle half. What lies above is before the blade too, and moves with it; the muscle below is
/// soft, and the blade turns away from it. Without bone within kBearingMm
/// (planner/approach/bearing_points.h) the blade bears with all its nodes. Sets HookPlacement::lever_mm and reach_mm,
/// puts the arm over the lip, and makes the blade no deeper than the lip: a surgeon takes a blade that fits the wall.
/// @param placement with nodes and an arm
/// @param skeleton labels of bone and cartilage
/// @return whether the blade bears on bone
bool bear_on_bone(HookPlacement& placement, const mesh::CutSession& session, std::span<const Label> skeleton);

/// The turn of a blade when the arms are this far apart: `play_rad`, or less where the blades' ends would meet.
double blade_turn(const HookPlacement& blade, double opening_mm, double play_rad);

/// How much less than its arm what the blade bears on moves, mm.
double behind_arm_mm(const HookPlacement& blade, double opening_mm, double play_rad);

/// The opening of the arms at which what the two blades bear on has moved apart by this much, mm.
double opening_of_arms(const std::array<const HookPlacement*, 2>& blades, double apart_mm, double play_rad);

} // namespace retractor::planner
