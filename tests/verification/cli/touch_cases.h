#pragma once
// Devices and touched tissue at their limits, for `retractor-verify --suite stability`: a finger that presses through
// the servo while its device jumps, falls silent or tells what is no number; bone under a hand; springs at and beyond
// their time step; numbers that are none. Each ends in an answer, or the servo lets go and says why. Units mm, N, MPa,
// s, tonne.

#include "tests/verification/framework/stability.h"

#include <vector>

namespace retractor {

/// The next four.
std::vector<StabilityCase> touch_cases();

StabilityCase device_fault_case();
StabilityCase bone_touch_case();
StabilityCase touch_spring_step_case();
StabilityCase bad_touch_parameters_case();

} // namespace retractor
