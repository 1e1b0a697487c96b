#pragma once
// The last stage of a stroke: the faces on the blade are found, and the elements on their two sides are given their own
// copies of the vertices between them. Units mm.

#include "mesh/cutting/stroke/cut_moves.h"

#include <span>
#include <vector>

namespace retractor::mesh {

/// All faces with every corner on the blade and elements on different sides of it, but those that their corners show
/// to be beyond a border.
const std::vector<BladeFace>& faces_on_blade(StrokeState& stroke);
/// Is some of the face within every border?
bool reaches_in(StrokeState& stroke, const BladeFace& face);
/// Decides which of them will be cut (StrokeState::cut_faces): those within the borders (and, while the blade grows,
/// with no corner beyond its end), less those between labels that the blade does not sever.
void decide_cut_faces(StrokeState& stroke);

/// An edge of the wound with both ends on its rim (at a corner of the blade, say) would stay closed, as neither end is
/// doubled: it gets a vertex of its own. So does a face with all its corners on the rim. False when there was none.
bool open_pinned_edges(StrokeState& stroke);

/// May the edge be bisected at p, which is near to its own point at t, without leaving a sliver?
bool keeps_volume(const CutStore& store, const EdgeKey& edge, const Vec3& p, double t);

/// Gives the two sides their own vertices and tags the lips with the cut's number.
/// @throws SolverError when the lips would hang together along an edge.
void separate(StrokeState& stroke, int cut_number);

} // namespace retractor::mesh
