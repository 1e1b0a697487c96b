#pragma once
// Fibre directions of elements, where they turn with a vessel or a muscle. Units mm, frame patient LPS.

#include "fem/material/tissue_law.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <string>

namespace retractor::fem {

/// @throws InputError when a coordinate is not finite, the axis is zero, or the angle is not between 0 and 90 degrees.
void check_fibres_around(const FibresAround& around, const std::string& where);

/// Of a law's fibres at rest in the middle of the element's corners: where they turn round an axis
/// (TissueLaw::around) their direction there, else the law's two fixed ones, wherever the element is.
/// @pre the element is one of the mesh's, and check_fibres_around() holds of the axis.
/// @throws InputError naming the element and its place when the axis that fibres turn round runs through it: there they
/// have no direction.
FibreDirections element_fibres(const mesh::TetMesh& mesh, TetId element, const TissueLaw& tissue);

} // namespace retractor::fem
