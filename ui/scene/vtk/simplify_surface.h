#pragma once
// Changes the number of triangles of a shape: fewer for a surface that is only seen from afar, more where an operation
// needs small triangles.

#include "mesh/base/geometry.h"

namespace retractor::ui {

/// Simplifies a surface by quadric error decimation [Garland, Heckbert 1997]. Borders may recede by about a triangle.
/// Labels are dropped, because triangles do not survive.
/// @param share share of the triangles that is kept, 0 to 1; 1 gives the surface itself
/// @throws InputError on a share out of range, indices out of range or coordinates that are not finite
TriMesh simplified(const TriMesh& surface, double share);

/// Divides triangles until no edge is longer than `longest_mm`. The shape stays the same, and neighbouring triangles
/// still meet. Labels are dropped.
/// @throws InputError on a length that is not positive, indices out of range or coordinates that are not finite
TriMesh with_edges_at_most(const TriMesh& surface, double longest_mm);

} // namespace retractor::ui
