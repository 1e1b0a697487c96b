#pragma once
// A submodel of an opened wound: only the elements near the wound, fixed where they bordered on the removed elements.
// The submodel is faster and stiffer than the whole. `retractor-verify --suite ladder` measures how much less a wound
// of each size opens (an incision of 60 mm needs about its own length of tissue round it); `retractor plan --local R
// --check` measures the same on the user's own wall. Units mm; frame patient LPS.

#include "fem/statics/elastic_problem.h"

#include <vector>

namespace retractor::fem {

struct LocalProblem {
    ElasticProblem problem;
    std::vector<VertexId> vertex_of; ///< vertex of the whole, per vertex of the submodel
    std::vector<TetId> tet_of; ///< element of the whole, per element of the submodel
    std::size_t rim_vertices = 0; ///< number of vertices fixed because they border on removed elements
};

/// @param points the wound
/// @param distance mm, from the points to the nearest corner of an element that is kept
/// @throws InputError without points, on a distance that is not positive, when a hook holds a vertex or a load acts on
/// an element that is removed, and on a body under pressure
LocalProblem local_problem(const ElasticProblem& whole, const Points& points, double distance);

} // namespace retractor::fem
