#pragma once
// An elastic problem as an input file for FEBio (febio_spec 4.0). FEBio is no package of the systems this program is
// made for: the tests check the file by reading it back (tests/verification/reference/febio_file_reader.h), not by
// running FEBio. Units mm, N, MPa.
//
// tet4 or tet10 by the mesh; one neo-Hookean material per label, whose linearisation is linear elasticity with the
// same E and nu; supports as "zero displacement", hooks as "prescribed displacement" along a ramp, in ten steps.
// FEBio's springs pull along the line between two nodes, so each bedded node hangs on three of them, along the axes,
// from anchors far away: to first order in the displacement over kFebioAnchorMm the same as a spring to the ground.
// [FEBio user manual 4, sections 3.5 to 3.16]

#include "fem/statics/elastic_problem.h"

#include <string>

namespace retractor::fem {

/// How far from its node an anchor of a bed spring lies.
inline constexpr double kFebioAnchorMm = 1000.0;

/// The whole file; the same text for the same problem, and every number with as many digits as give it back.
/// @throws InputError as check_problem() does, and on a problem with loads.
std::string febio_file(const ElasticProblem& problem);

} // namespace retractor::fem
