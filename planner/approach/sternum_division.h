#pragma once
// Finds the strokes that saw the sternum across at the lower end of an incision over it, as in an upper hemisternotomy:
// to the right edge (J), to the left one, or to both (T). Units mm; frame patient LPS.

#include "mesh/image/volume.h"
#include "planner/anatomy/anatomy.h"
#include "planner/case/approach.h"

namespace retractor::planner {

/// Distance by which the saw goes beyond the sternum's edge, into the soft tissue between two cartilages; the mammary
/// artery runs farther out, about 10 to 15 mm beside the sternum.
inline constexpr double kBeyondSternumEdgeMm = 4.0;

/// Fills Division::strokes and Division::words of an approach that divides the sternum; clears them otherwise. Where no
/// sternum lies under the incision's lower end, or the approach leaves the sternum whole (Approach::uncut_labels),
/// there are no strokes, and the words tell the reason. The strokes sever the sternum and the soft tissue behind its
/// outer side; skin, ribs and cartilages stay whole.
void find_sternum_division(Approach& approach, const mesh::LabelVolume& labels, const Anatomy& anatomy);

} // namespace retractor::planner
