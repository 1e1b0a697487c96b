#pragma once
// Opens the slivers that a blade leaves, before the lips are separated. Short edges at vertices that the stroke has
// made are contracted. Vertices are shifted by hill climbing on the smallest dihedral angle (Freitag and Ollivier-Gooch
// 1997), within their surfaces and interfaces, the blade and its borders; vertices on bends and earlier wounds do not
// move. Remaining slivers are flipped (cut_flips.h) where no face and no edge on the blade takes part. Sequential and
// deterministic. Units mm.

#include "mesh/cutting/stroke/cut_moves.h"

namespace retractor::mesh {

/// Improves the elements round the blade with a smallest dihedral angle below CutOptions::improve_below_deg.
void improve_near_blade(StrokeState& stroke);

} // namespace retractor::mesh
