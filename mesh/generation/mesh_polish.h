#pragma once
// Polishes a tetrahedral mesh of labelled space without changing its connectivity. The flattest elements are opened by
// moving their vertices: hill climbing on the smallest dihedral angle (Freitag and Ollivier-Gooch 1997). Interfaces are
// shifted so that their flat facets enclose the labels' volume instead of being inscribed in it. Vertices stay on their
// interfaces. Vertices where three labels meet stay in place, but move a little when an element could not be opened
// otherwise. Local frame of mesh/image/label_field.h, mm. Sequential and deterministic.

#include "mesh/base/job.h"
#include "mesh/generation/delaunay_mesher.h"
#include "mesh/image/label_field.h"

namespace retractor::mesh {

/// Opens elements with a dihedral angle below `target_deg` by moving single vertices; some elements may stay below.
void open_flat_tets(LocalMesh& mesh, const LabelField& field, double target_deg, const Job& job = {});

/// Moves the vertices at the bottom of pits outwards. A vertex of the body's surface that lies deeper than half a voxel
/// below the label field's surface moves onto it, or a part of the way. Layers thinner than the cells leave such pits,
/// of which cell_labels.h fills those of one and two cells. No move takes an element below `smallest_deg`, or further
/// below.
void raise_pits(LocalMesh& mesh, const LabelField& field, double smallest_deg, const Job& job = {});

/// Moves the vertices of each interface along its normal until the facets lie on the interface on average. No move
/// takes an element below `smallest_deg`, or further below.
void fit_interfaces(LocalMesh& mesh, const LabelField& field, double smallest_deg, const Job& job = {});

} // namespace retractor::mesh
