#pragma once
// The pieces of a body that is being cut, and marking what an ablation removes: a piece, or elements of some labels in
// a ball. Element ids are the session's. Units mm; frame patient LPS (rest
// configuration).
//
// Pieces are joined by faces and found on demand, at the cost of the whole mesh. An element is in a region when its
// centroid is: cut along the region's border first where the border matters.

#include "mesh/cutting/cut_session.h"

#include <Eigen/Geometry>

#include <span>
#include <utility>
#include <vector>

namespace retractor::mesh {

struct Piece {
    std::vector<TetId> tets; ///< by id
    double volume_mm3 = 0.0;
    Vec3 centroid = Vec3::Zero();
    std::vector<std::pair<Label, double>> labels; ///< what it is made of: label and mm^3, the largest share first
};

/// All pieces, by number: the one with most elements is 0 (among equal ones, that with the smallest id).
std::vector<Piece> find_pieces(const CutSession& session);

/// Elements (by id) of these labels with the centroid in the ball; no labels: of all.
/// @throws InputError on NaN, a radius that is not positive.
std::vector<TetId> mark_ball(
    const CutSession& session, const Vec3& centre, double radius_mm, std::span<const Label> labels = {});
} // namespace retractor::mesh
