#pragma once
// Finds groups of connected elements round a vertex or an edge after some faces are cut.

#include "mesh/cutting/store/cut_store.h"
#include "mesh/cutting/stroke/cut_faces.h"

#include <vector>

namespace retractor::mesh {

/// Elements in ascending order; groups ordered by their first element.
using Groups = std::vector<std::vector<TetId>>;

/// The elements round a vertex (or an edge), in groups that are connected by uncut faces at the vertex (or the edge).
Groups groups_round(VertexId v, const CutStore& store, const CutFaces& cut);
Groups groups_round(const EdgeKey& edge, const CutStore& store, const CutFaces& cut);

/// True when two fans of elements round an edge are connected at both ends of the edge, so that they would share both
/// ends after the cut.
/// @param fans groups round the edge
/// @param at_a, at_b groups round the ends of the edge
bool pinned(const Groups& fans, const Groups& at_a, const Groups& at_b);

} // namespace retractor::mesh
