#pragma once
// Fewer triangles for the same shape, what is only looked at, and from afar, need not be as fine as the CT; or more,
// where what is done to them needs them small.

#include "mesh/base/geometry.h"

namespace retractor::ui {

/// @param share of the triangles that is kept, 0 to 1; 1 gives the surface itself. Quadric error decimation [Garland,
/// Heckbert 1997]; borders may recede by about a triangle. Labels are dropped: faces do not survive.
/// @throws InputError on a share out of range, indices out of range or coordinates that are not finite.
TriMesh simplified(const TriMesh& surface, double share);

/// The same shape with no edge longer than that; where triangles met they still meet. Labels are dropped.
/// @throws InputError on a length that is not positive, indices out of range or coordinates that are not finite.
TriMesh with_edges_at_most(const TriMesh& surface, double longest_mm);

} // namespace retractor::ui
