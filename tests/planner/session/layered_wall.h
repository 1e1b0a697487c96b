#pragma once
// A slab of skin, fat and muscle for the knife, with a strip of bare bone: 120 x 30 x 120 mm, skin at y = 0, outward
// -y.

#include "planner/session/surgery_session.h"

namespace retractor::planner {

inline constexpr double kSlabThicknessMm = 30.0;
inline constexpr double kSlabEdgeMm = 5.0;
inline constexpr Label kSkin = 1, kFat = 2, kMuscle = 3, kBone = 4;

/// Held at the four sides. Bone lies bare where x > 100.
/// @param shift moves all of it, mm.
SurgerySetup layered_wall(const Vec3& shift = Vec3::Zero());

/// With an approach of 60 mm across it and a hook on each lip that pulls like this, 6 mm where no force is asked for.
/// @param hook_depth_mm below the skin.
SurgerySetup wall_with_planned_hooks(const HookPull& pull, double hook_depth_mm);

/// Straight down on the skin of the slab.
Ray ray_down(double x, double z);

} // namespace retractor::planner
