#pragma once
// An elastic problem as an input file for FEBio (febio_spec 4.0), and that file read back: FEBio is no package of the
// systems this program is made for, so what is written is checked by reading, not by running. Units mm, N, MPa.
//
// tet4 or tet10 by the mesh; one neo-Hookean material per label, whose linearisation is linear elasticity with the
// same E and nu; supports as "zero displacement", hooks as "prescribed displacement" along a ramp, in ten steps.
// FEBio's springs pull along the line between two nodes, so each bedded node hangs on three of them, along the axes,
// from anchors far away: to first order in the displacement over kFebioAnchorMm the same as a spring to the ground.
// [FEBio user manual 4, sections 3.5 to 3.16]

#include "fem/statics/elastic_problem.h"

#include <string>
#include <string_view>

namespace retractor::fem {

/// How far from its node an anchor of a bed spring lies.
inline constexpr double kFebioAnchorMm = 1000.0;

/// The whole file; the same text for the same problem, and every number with as many digits as give it back.
/// @throws InputError as check_problem() does, and on a problem with loads.
std::string febio_file(const ElasticProblem& problem);

/// Reads what febio_file() wrote: mesh, labels, materials by label (name, E, nu, density), supports, beds, hooks. Sides
/// of hooks, sources of materials and the order of beds are not in the file: sides are read as 0, beds rise by vertex.
/// @throws InputError naming the line of what is missing, of a kind that febio_file() does not write, or not XML.
ElasticProblem read_febio_file(std::string_view text);

/// The first difference between two problems in what a file can hold, in words; empty: there is none, to the last bit.
std::string first_difference(const ElasticProblem& a, const ElasticProblem& b);

} // namespace retractor::fem
