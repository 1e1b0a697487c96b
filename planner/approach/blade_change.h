#pragma once
// A blade that goes deeper or in another direction. Units mm; frame patient LPS.

#include "planner/case/approach.h"
#include "planner/case/patient.h"

namespace retractor::planner {

/// Largest angle between a blade and the straight way into the skin, degrees: a flatter blade shaves the skin (ours).
inline constexpr double kMostTiltedDeg = 60.0;

/// The same approach with a blade that goes to another depth, and is turned as a whole, so that it points along
/// `inward` at the middle of the incision. Hooks or retractor are placed anew.
/// @throws InputError on a depth or a tilt out of range, where the blade folds over itself, and as with_incision_of()
/// does
Approach with_blade(Patient& patient, const Approach& approach, double depth_mm, const Vec3& inward);

} // namespace retractor::planner
