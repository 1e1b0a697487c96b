#pragma once
// Fibre directions of elements. Fibres may wind round the axis of a vessel or a muscle. Units mm, frame patient LPS.

#include "fem/material/tissue_law.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <string>

namespace retractor::fem {

/// @throws InputError when a coordinate is not finite, when the axis is zero, or when the angle is not between 0 and
/// 90 degrees. `where` is the place that the error names.
void check_fibres_around(const FibresAround& around, const std::string& where);

/// Fibre directions at rest of one element. Where the fibres wind round an axis (TissueLaw::around), the directions
/// belong to the mean of the element's corners. Otherwise the directions are the law's two fixed ones.
/// @pre the element exists in the mesh, and check_fibres_around() accepts the axis.
/// @throws InputError naming the element and its place when the axis runs through the element: fibres have no
/// direction on their own axis.
FibreDirections element_fibres(const mesh::TetMesh& mesh, TetId element, const TissueLaw& tissue);

} // namespace retractor::fem
