#pragma once
// The extreme cases of the finite elements, by family.

#include "tests/verification/framework/stability.h"

namespace retractor::verification {

StabilityCase incompressible_case();
StabilityCase bone_beside_fat_case();
StabilityCase tiny_element_case();
StabilityCase sharp_angles_case();
StabilityCase severed_piece_case();
StabilityCase cut_along_grid_case();
StabilityCase cut_through_hook_case();
StabilityCase hundred_cuts_case();
StabilityCase far_hook_case();
StabilityCase crossing_hooks_case();
StabilityCase meeting_hooks_case();
StabilityCase inverted_start_case();
StabilityCase high_pressure_case();
StabilityCase spring_step_case();
StabilityCase strange_case();

} // namespace retractor::verification
