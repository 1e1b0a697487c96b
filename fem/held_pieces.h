#pragma once
// Is every piece of a mesh held? A piece that can move or turn freely makes the stiffness singular.

#include "mesh/tet_mesh.h"

#include <span>

namespace retractor {

/// Pieces are joined by faces. One is held when three of its nodes that are not on one line are `held_nodes`, or belong
/// to pieces that are held themselves.
/// @throws SolverError naming the first piece that is not: its number of elements, volume and place.
void check_pieces_held(const TetMesh& mesh, std::span<const VertexId> held_nodes);

} // namespace retractor
