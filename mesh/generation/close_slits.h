#pragma once
// Closes narrow slits in the surface of a tetrahedral mesh of labelled space, and trims its fins. Where a layer is
// thinner than the cells, the mesher leaves cells out: two faces of the surface then stand against each other like the
// sides of an open book, while the label field has tissue between them. Or it keeps a flat cell that stands out. Local
// frame of mesh/image/label_field.h, mm. Sequential and deterministic.

#include "mesh/base/job.h"
#include "mesh/generation/delaunay_mesher.h"
#include "mesh/image/label_field.h"

#include <cstddef>

namespace retractor::mesh {

/// Adds an element between two faces of the surface that share an edge and stand at less than a right angle to each
/// other, where the label field has tissue. An element is not added that has a dihedral angle below `smallest_deg`,
/// lies in elements round its corners by the places that are tested, or leaves the surface as sharp as it is. No vertex
/// moves.
/// @return the number of elements added
std::size_t close_slits(LocalMesh& mesh, const LabelField& field, double smallest_deg, const Job& job = {});

/// Removes elements at which the surface folds outwards by more than a right angle, where this makes the surface less
/// sharp: flat elements, and elements where the label field has no tissue. The last element at a vertex stays.
/// @return the number of elements removed
std::size_t trim_fins(LocalMesh& mesh, const LabelField& field, const Job& job = {});

} // namespace retractor::mesh
