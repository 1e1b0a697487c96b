#pragma once
// A block of two tissues that lies on its back, rests on beds at two sides, and is pulled apart by two hooks on its
// top.

#include "fem/statics/elastic_problem.h"

#include <cstdint>
#include <vector>

namespace retractor::test_support {

/// A block of 60 x 40 x 20 mm in cubes of 20 / `fineness` mm, with label 1 below and label 2 above. The hooks of 10 x
/// 20 mm lie on the grid for every even fineness, so that finer meshes solve the same problem.
/// @param nodes_per_tet 4 (P1) or 10 (P2)
fem::ElasticProblem hooked_block(int fineness, int nodes_per_tet);

/// One entry per element: 1 within 9 mm of the hooks. These elements are less than half of the block, and a part of
/// each bed lies beyond them.
std::vector<std::uint8_t> near_hooks(const fem::ElasticProblem& problem);

} // namespace retractor::test_support
