#pragma once
// Writes an elastic problem as an input file for FEBio (febio_spec 4.0). Tests read the written files
// (tests/verification/reference/febio_file_reader.h) instead of running FEBio, because the supported systems do not
// package FEBio. Units mm, N, MPa.
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
/// @throws InputError as check_problem() does, and on a problem with loads or hinges.
std::string febio_file(const ElasticProblem& problem);

} // namespace retractor::fem
