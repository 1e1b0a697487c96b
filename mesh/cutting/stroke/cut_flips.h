#pragma once
// Flips: a few elements of one label are replaced by other elements on the same vertices that fill the same hole. No
// vertex moves, and the faces that bound the hole stay, wounds included. The functions below first compute a flip with
// its effect on the angles; make_flip() then carries it out. Face flips (2-3) and edge removal (3-2, 4-4, and rings of
// up to kMostRing elements) follow Freitag and Ollivier-Gooch 1997. The best triangulation of a ring comes from dynamic
// programming (Klincsek 1980, in Shewchuk 2002, "Two discrete optimization algorithms for the topological improvement
// of tetrahedral meshes"). Units mm.

#include "mesh/cutting/store/cut_store.h"
#include "mesh/cutting/stroke/cut_marks.h"

#include <optional>
#include <vector>

namespace retractor::mesh {

/// Largest ring round an edge. Longer rings have too many triangulations and rarely give better elements.
inline constexpr std::size_t kMostRing = 7;

struct Flip {
    std::vector<TetId> gone; ///< elements to remove, ascending
    std::vector<TetSlot> born; ///< elements to add; make_flip() sets their lips and origins
    std::vector<FaceKey> faces_gone, faces_born; ///< faces within the hole, before and after
    std::vector<EdgeKey> edges_gone; ///< edges within the hole that vanish
    double cosine_before = 1.0, cosine_after = 1.0; ///< cosine of the smallest dihedral angle in the hole
};

/// Replaces the two elements at the face opposite a corner of t by three elements round a new edge. Returns nothing
/// when the face is on a surface or between two labels, when the edge exists already, or when an element would have no
/// volume.
std::optional<Flip> face_flip(const CutStore& store, TetId t, int corner);

/// Replaces the elements round an edge by elements without the edge, such that the smallest dihedral angle is as large
/// as possible. Returns nothing when the edge is on a surface or between two labels, when its ring is longer than
/// kMostRing, when an existing edge or face would be made again, or when elements would have no volume.
std::optional<Flip> edge_flip(const CutStore& store, const EdgeKey& edge);

/// Carries out a flip. Faces keep their lips. Each new element gets the origin of the old element with which it shares
/// the most volume.
/// @return the new elements
std::vector<TetId> make_flip(CutStore& store, const Flip& flip);

/// Volume (mm^3) of the intersection of two elements.
double shared_volume(const std::array<Vec3, 4>& a, const std::array<Vec3, 4>& b);

} // namespace retractor::mesh
