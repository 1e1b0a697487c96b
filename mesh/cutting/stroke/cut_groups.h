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

} // namespace retractor::mesh
