#pragma once
// Writes an elastic problem as an input file for FEBio (febio_spec 4.0) and reads that file. Tests read the written
// files instead of running FEBio, because the supported systems do not package FEBio. Units mm, N, MPa.
//
// Elements are tet4 or tet10, as in the mesh. Each label has one neo-Hookean material that linearises to linear
// elasticity with the same E and nu. Supports become "zero displacement", hooks "prescribed displacement" along a
// ramp in ten steps. FEBio's springs pull along the line between two nodes. Each bedded node therefore has three
// springs along the axes, to anchors at the distance kFebioAnchorMm. To first order in the displacement over this
// distance such a spring acts like a spring to the ground.
// [FEBio user manual 4, sections 3.5 to 3.16]

#include "fem/statics/elastic_problem.h"

#include <string>

namespace retractor::fem {

/// Distance of a bed spring's anchor from its node, mm.
inline constexpr double kFebioAnchorMm = 1000.0;

/// The whole file. The same problem always gives the same text. Every number has enough digits to be read back
/// exactly.
/// @throws InputError as check_problem() does, and on a problem with loads.
std::string febio_file(const ElasticProblem& problem);

/// Reads a file of febio_file(): mesh, labels, materials by label (name, E, nu, density), supports, beds and hooks.
/// The file does not contain the sides of hooks, the sources of materials and the order of beds: sides are read as 0,
/// and beds are sorted by vertex.
/// @throws InputError naming the line of an item that is missing, that febio_file() does not write, or that is not
/// XML.
ElasticProblem read_febio_file(std::string_view text);

/// The first difference between two problems in the content of a file, in words, exact to the last bit; empty when
/// there is none.
std::string first_difference(const ElasticProblem& a, const ElasticProblem& b);

} // namespace retractor::fem
