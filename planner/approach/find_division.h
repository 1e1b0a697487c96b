#pragma once
// Finds what an approach divides beyond its skin incision. Units mm; frame patient LPS.

#include "planner/case/approach.h"
#include "planner/case/patient.h"

namespace retractor::planner {

/// Fills Division::strokes and Division::words as the division's extent asks: see find_space_division() and
/// find_sternum_division(); clears them for an approach that divides nothing beyond the skin. The patient's landmarks
/// are looked for only where they are needed. Landmarks that are missing are a reason in words.
void find_division(Approach& approach, Patient& patient);

/// Gives an approach another division. Where it divides the sternum, the blade saws the sternum too, and calcified
/// cartilage without a name of its own.
void set_division(Approach& approach, const Division& division);

} // namespace retractor::planner
