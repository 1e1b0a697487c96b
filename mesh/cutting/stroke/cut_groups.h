#pragma once
// What hangs together round a vertex or an edge, once some faces are cut.

#include "mesh/cutting/store/cut_store.h"
#include "mesh/cutting/stroke/cut_faces.h"

#include <vector>

namespace retractor::mesh {

/// Elements by id; groups by their first element.
using Groups = std::vector<std::vector<TetId>>;

/// The elements round the vertex (edge) in groups joined by faces at it that are not cut.
Groups groups_round(VertexId v, const CutStore& store, const CutFaces& cut);
Groups groups_round(const EdgeKey& edge, const CutStore& store, const CutFaces& cut);

} // namespace retractor::mesh
