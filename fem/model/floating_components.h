#pragma once
// Is every piece of a mesh held? A piece that can move or turn freely makes the stiffness singular.

#include "mesh/tetrahedra/tet_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace retractor::fem {

/// Which pieces are held, one flag per piece. A piece is held when three of its nodes that are not on one line are
/// `held_nodes`, or belong to pieces that are held themselves.
/// @param piece_of_tet from connected_pieces().
std::vector<std::uint8_t> held_components(
    const mesh::TetMesh& mesh, std::span<const int> piece_of_tet, std::span<const VertexId> held_nodes);

/// Pieces are joined by faces. One is held when three of its nodes that are not on one line are `held_nodes`, or belong
/// to pieces that are held themselves.
/// @throws SolverError naming the first piece that is not: its number of elements, volume and place, and what is
/// missing: any hold at all, or what keeps it from turning about a vertex or a line.
void check_no_floating_component(const mesh::TetMesh& mesh, std::span<const VertexId> held_nodes);

} // namespace retractor::fem
