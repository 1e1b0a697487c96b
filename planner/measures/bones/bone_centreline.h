#pragma once
// Measures along a long bone, as a rib or a sternum: for each vertex the distance from one end of the bone along its
// centre-line. Units mm.
//
// The bone is divided into slices by the distance along the edges of its mesh from one of its ends. The line through
// the centroids of the slices is a first centre-line. Vertices are projected onto the line, divided into slices again,
// and the line is drawn anew, until the slices stand across the line.

#include "mesh/tetrahedra/tet_mesh.h"

#include <vector>

namespace retractor::planner {

struct BoneCentreline {
    double length_mm = 0.0; ///< from the lowest to the highest value of `along_mm`
    std::vector<double> along_mm; ///< per node: distance from the first end, from 0 to the length
};

/// @param bone one connected piece; every node belongs to an element
/// @return a length of 0, and 0 for each node, when the bone is not longer than two slices
BoneCentreline bone_centreline(const mesh::TetMesh& bone);

} // namespace retractor::planner
