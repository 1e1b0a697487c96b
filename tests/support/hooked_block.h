#pragma once
// A block of two tissues on its back, bedded on two sides and pulled apart by two hooks on its top.

#include "fem/statics/elastic_problem.h"

#include <cstdint>
#include <vector>

namespace retractor::test_support {

/// 60 x 40 x 20 mm in cubes of 20 / `fineness` mm; labels 1 (below) and 2 (above); hooks of 10 x 20 mm that lie on
/// the grid for every even fineness, so that finer meshes solve the same problem. P1 or P2 by `nodes_per_tet`.
fem::ElasticProblem hooked_block(int fineness, int nodes_per_tet);

/// 1 for each element within 9 mm of the hooks: less than half of the block, both beds partly beyond.
std::vector<std::uint8_t> near_hooks(const fem::ElasticProblem& problem);

} // namespace retractor::test_support
