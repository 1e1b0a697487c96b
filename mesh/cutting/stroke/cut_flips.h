#pragma once
// Flips: a few elements of one label are taken out and the hole they leave is filled with others on the same vertices.
// Nothing moves, and the faces that bound the hole stay what they are, wounds included. A flip is looked at first and
// made afterwards, by whoever likes what it makes of the angles. Face flips (2-3) and edge removal (3-2, 4-4, and rings
// of up to kMostRing elements; the best triangulation of the ring by dynamic programming) are those of [Freitag &
// Ollivier-Gooch 1997] and [Klincsek 1980, in Shewchuk 2002, "Two discrete optimization algorithms for the topological
// improvement of tetrahedral meshes"]. Units mm.

#include "mesh/cutting/store/cut_store.h"
#include "mesh/cutting/stroke/cut_marks.h"

#include <optional>
#include <vector>

namespace retractor::mesh {

/// Longer rings have too many triangulations to be worth it, and hardly ever give better elements.
inline constexpr std::size_t kMostRing = 7;

struct Flip {
    std::vector<TetId> gone; ///< by id
    std::vector<TetSlot> born; ///< their lips and origins are filled in by make_flip()
    std::vector<FaceKey> faces_gone, faces_born; ///< within the hole
    std::vector<EdgeKey> edges_gone;
    double cosine_before = 1.0, cosine_after = 1.0; ///< of the smallest dihedral angle of all
};

/// Three elements round a new edge instead of two at the face opposite to a corner of t. Nothing where the face is of a
/// surface or between two labels, where the edge is there already, or where an element would have no volume.
std::optional<Flip> face_flip(const CutStore& store, TetId t, int corner);

/// The elements round an edge by others without it, with the largest smallest dihedral angle there is. Nothing where
/// the edge is on a surface or between two labels, where its ring is longer than kMostRing, where an edge or a face
/// that is there already would be made again, or where elements would have no volume.
std::optional<Flip> edge_flip(const CutStore& store, const EdgeKey& edge);

/// Puts the new elements in place of the old. Faces keep their lips; each element is said to be a part of the origin of
/// the old element that it shares the most volume with.
/// @returns the new elements.
std::vector<TetId> make_flip(CutStore& store, const Flip& flip);

/// Volume (mm^3) that two elements share.
double shared_volume(const std::array<Vec3, 4>& a, const std::array<Vec3, 4>& b);

} // namespace retractor::mesh
