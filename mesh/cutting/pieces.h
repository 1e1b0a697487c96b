#pragma once
// Finds the pieces of a body that is being cut, and marks elements of some labels in a ball for an ablation. Element
// ids are ids of the session. Units mm; frame patient LPS (the rest configuration).
//
// Elements of a piece are connected by faces. Every search for pieces visits the whole mesh. An element is in a region
// when its centroid is in the region; where the border matters, cut along the border first.

#include "mesh/cutting/cut_session.h"

#include <Eigen/Geometry>

#include <span>
#include <utility>
#include <vector>

namespace retractor::mesh {

struct Piece {
    std::vector<TetId> tets; ///< ascending ids
    double volume_mm3 = 0.0;
    Vec3 centroid = Vec3::Zero();
    std::vector<std::pair<Label, double>> labels; ///< volume (mm^3) of each label, the largest first
};

/// All pieces; the piece with most elements comes first (among equal pieces, the piece with the smallest id).
std::vector<Piece> find_pieces(const CutSession& session);

/// Elements (ascending ids) of these labels with the centroid in the ball. Without labels: elements of all labels.
/// @throws InputError on NaN or a radius that is not positive
std::vector<TetId> mark_ball(
    const CutSession& session, const Vec3& centre, double radius_mm, std::span<const Label> labels = {});
} // namespace retractor::mesh
