#pragma once
// Last touches on a tetrahedral mesh of labelled space, without changing its connectivity: the flattest
// elements are opened by moving their vertices (hill climbing on the smallest dihedral angle, [Freitag &
// Ollivier-Gooch 1997]), and interfaces are shifted so that their flat facets enclose the labels' volume
// instead of being inscribed in it. Vertices stay on their interfaces; where three labels meet they do not
// move, except by a little when an element could not be opened otherwise. Local frame of mesh/label_field.h, mm.
// Sequential and deterministic.

#include "mesh/base/job.h"
#include "mesh/generation/delaunay_mesher.h"
#include "mesh/image/label_field.h"

namespace retractor::mesh {

/// Opens elements with a dihedral angle below `target_deg` as far as moving single vertices can.
void open_flat_tets(LocalMesh& mesh, const LabelField& field, double target_deg, const Job& job = {});

/// Moves the vertices of each interface along its normal until its facets lie on the interface on average.
/// A move that would take an element below `smallest_deg` (or further below) is not made.
void fit_interfaces(LocalMesh& mesh, const LabelField& field, double smallest_deg, const Job& job = {});

} // namespace retractor::mesh
