#pragma once
// A part of an opened wound's body in place of the whole: the elements near the wound, held still where they bordered
// on the others. Faster and stiffer; by how much a wound of its size is closed by it, `retractor-verify --suite ladder`
// measures (an incision of 60 mm needs about its own length round it), and
// `retractor plan --local R --check` on the user's own wall. Units mm; frame patient LPS.

#include "fem/statics/elastic_problem.h"

#include <vector>

namespace retractor::fem {

struct LocalProblem {
    ElasticProblem problem;
    std::vector<VertexId> vertex_of; ///< per vertex of the part: the vertex of the whole
    std::vector<TetId> tet_of; ///< per element of the part: the element of the whole
    std::size_t rim_vertices = 0; ///< held because they bordered on elements that are left out
};

/// @param points what must be near: the wound. @param distance mm, of an element's nearest corner.
/// @throws InputError when there is no point, the distance is not positive, or a hook holds a vertex, or a load acts on
/// an element, that is left out, and on a body under pressure.
LocalProblem local_problem(const ElasticProblem& whole, const Points& points, double distance);

} // namespace retractor::fem
