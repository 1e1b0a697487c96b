#pragma once
// How many tetrahedra a size field asks for, before they are made. Time and memory of a plan follow from this number.

#include "mesh/generation/size_field.h"
#include "mesh/image/label_field.h"

namespace retractor::mesh {

/// Expected number of tetrahedra: the integral of 1 / (c edge^3) over the wall, by samples at voxel centres, with the
/// mean volume c of a tetrahedron of edge length 1 in meshes of this mesher. The number of a finished mesh lies between
/// half and twice of it: thin layers and small features add elements that no sample sees.
double expected_tetrahedra(const LabelField& field, const SizeField& size);

} // namespace retractor::mesh
