#pragma once
// Checks that supports hold every connected piece of a mesh. A piece that can move or turn freely makes the stiffness
// singular.

#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::fem {

/// Flags the pieces that are held, one flag per piece. A piece is held when three of its nodes that are not on one
/// line belong to `held_nodes` or to pieces that are held themselves.
/// @param piece_of_tet result of connected_pieces().
std::vector<std::uint8_t> held_components(
    const mesh::TetMesh& mesh, std::span<const int> piece_of_tet, std::span<const VertexId> held_nodes);

/// Checks that every piece is held, by the rule of held_components(). Elements that share a face belong to one piece.
/// @throws SolverError for the first piece that is not held, with its number of elements, volume and place. The
/// message says whether nothing holds the piece, or about which vertex or line the piece can turn.
void check_no_floating_component(const mesh::TetMesh& mesh, std::span<const VertexId> held_nodes);

} // namespace retractor::fem
