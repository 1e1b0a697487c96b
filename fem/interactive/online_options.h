#pragma once
// Options of an opening that is solved while the body is cut (OnlineOpening).

#include "fem/interactive/multifrontal_factor.h"
#include "mesh/base/geometry.h"

#include <cstddef>
#include <vector>

namespace retractor::fem {

/// Representation of the body between cuts: condensed onto the dense system of the corridor (CondensedBody), or divided
/// into a tree of parts (MultifrontalFactor), which is cheaper for large corridors. by_cost chooses the cheaper.
enum class BodyKept { by_cost, condensed, dissected };

struct OnlineOptions {
    /// Limit of |f - K u| over the free unknowns, relative to the load; answers above are refined.
    double residual = 1e-8;
    /// Number of vertices that cuts or hooks may add to the corridor before a new factorisation is cheaper.
    std::size_t added_vertices = 150;
    BodyKept body = BodyKept::by_cost;
    std::size_t part_vertices = kPartVertices; ///< for dissect(), when the body is divided
    /// Number of changed vertices from which the changes of a stroke are moved into an updated state, on another
    /// thread: about two steps of 5 mm through elements of 4 mm.
    std::size_t update_vertices = 100;
    /// Number of deltas after which the updated state replaces the old state, even if the new state was ready earlier,
    /// so that the bits do not depend on the speed of the thread. The solver waits for a state that is not ready then.
    int update_deltas = 2;
    /// Tension (MPa) per element of the session's first mesh, which cuts release (pre_strain.h); empty: none.
    std::vector<Mat3> stress_of_element {};
};

} // namespace retractor::fem
