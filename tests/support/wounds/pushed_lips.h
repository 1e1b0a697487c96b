#pragma once
// A block with a straight cut, whose lips two hooks push against each other or draw apart. Units mm, MPa.

#include "fem/statics/elastic_problem.h"

#include <utility>
#include <vector>

namespace retractor::test_support {

struct PushedLips {
    fem::ElasticProblem problem;
    std::vector<std::pair<VertexId, VertexId>> pairs; ///< vertices of the two lips that were one
};

/// A block of 48 x 32 x 12 mm, cut round its middle x = 24 to a depth of 8 mm, and held from below. The left hook moves
/// by `each_side` mm towards the cut, and the right hook by as much against it.
PushedLips lips_pushed(double each_side);

} // namespace retractor::test_support
