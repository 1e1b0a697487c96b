#pragma once
// Devices and touched tissue at their limits, for `retractor-verify --suite stability`: a finger that presses through
// the servo while its device jumps, falls silent or tells what is no number; bone under a hand; springs at and beyond
// their time step. Each ends in an answer, or the servo lets go and says why. Units mm, N, MPa,
// s, tonne.

#include "tests/verification/framework/stability.h"

#include <vector>

namespace retractor::verification {

/// The next three.
std::vector<StabilityCase> touch_cases();

StabilityCase device_fault_case();
StabilityCase bone_touch_case();
StabilityCase touch_spring_step_case();

} // namespace retractor::verification
