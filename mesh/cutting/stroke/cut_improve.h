#pragma once
// Opening the slivers that a blade leaves, before its lips are parted: short edges at vertices that the stroke has made
// are contracted, vertices are shifted (hill climbing on the smallest dihedral angle, [Freitag & Ollivier-Gooch
// 1997]) within what holds them: surfaces, interfaces, the blade and its borders; bends and earlier wounds do not move.
// What is left is flipped (cut_flips.h), where no face and no edge on the blade takes part.
// Sequential and deterministic. Units mm.

#include "mesh/cutting/stroke/cut_moves.h"

namespace retractor::mesh {

/// Works on the elements round the blade whose smallest dihedral angle is below CutOptions::improve_below_deg.
void improve_near_blade(StrokeState& stroke);

} // namespace retractor::mesh
