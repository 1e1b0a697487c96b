#pragma once
// Extreme cases of devices and touched tissue, for `retractor-verify --suite stability`: a finger that presses
// through the servo while its device jumps, falls silent or reports NaN; bone under a hand; springs at and beyond the
// bound of their time step. Each case ends in an answer, or in a fault of the servo with a reason. Units mm, N, MPa,
// s, tonne.

#include "tests/verification/framework/stability.h"

#include <vector>

namespace retractor::verification {

/// All three cases below.
std::vector<StabilityCase> touch_cases();

StabilityCase device_fault_case();
StabilityCase bone_touch_case();
StabilityCase touch_spring_step_case();

} // namespace retractor::verification
