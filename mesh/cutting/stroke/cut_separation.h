#pragma once
// The last stage of a stroke: finds the faces on the blade, and gives the elements on the two sides their own copies of
// the vertices between them. Units mm.

#include "mesh/cutting/stroke/cut_moves.h"

#include <vector>

namespace retractor::mesh {

/// All faces with every corner on the blade and with elements on different sides of the blade, without faces whose
/// corners lie beyond a border.
const std::vector<BladeFace>& faces_on_blade(StrokeState& stroke);
/// True when a part of the face is within every border.
bool reaches_in(StrokeState& stroke, const BladeFace& face);
/// Decides which faces on the blade will be cut, and puts them into StrokeState::cut_faces: faces within the borders,
/// without faces between labels that the blade does not sever. While the blade grows, faces with a corner beyond its
/// end are left out too.
void decide_cut_faces(StrokeState& stroke);

/// Opens edges of the wound with both ends on its rim, for example at a corner of the blade. Such an edge would stay
/// closed, because neither end is doubled; therefore the edge gets a vertex of its own. A face with all corners on the
/// rim gets a vertex too. Returns false when there was no such edge or face.
bool open_pinned_edges(StrokeState& stroke);

/// True when bisecting the edge at p leaves no sliver. The point p is near the point of the edge at t (0 to 1).
bool keeps_volume(const CutStore& store, const EdgeKey& edge, const Vec3& p, double t);

/// Gives the two sides their own vertices and tags the lips with StrokeState::cut_number.
/// @throws SolverError when the lips would stay connected along an edge
void separate(StrokeState& stroke);

} // namespace retractor::mesh
