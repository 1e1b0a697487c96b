#pragma once
// How an opening is solved while it is cut (OnlineOpening).

#include "fem/interactive/multifrontal_factor.h"
#include "mesh/base/geometry.h"

#include <cstddef>
#include <vector>

namespace retractor::fem {

/// How the body is kept between cuts: condensed onto the corridor's dense system (CondensedBody), or, where so much is
/// touched that this would cost more, taken apart (MultifrontalFactor).
enum class BodyKept { by_cost, condensed, dissected };

struct OnlineOptions {
    double residual = 1e-8; ///< answers with more are refined: |f - K u| over the free unknowns, relative to the load
    /// Unknown vertices that cuts or hooks may add to the corridor before a new factorisation is cheaper.
    std::size_t added_vertices = 150;
    BodyKept body = BodyKept::by_cost;
    std::size_t part_vertices = kPartVertices; ///< of a body taken apart, as dissect() takes it
    /// What a stroke has changed is folded into the state that later steps are set up against once so many vertices
    /// are changed: about two steps of 5 mm through elements of 4 mm. On a thread of its own.
    std::size_t update_vertices = 100;
    /// The folded state is swapped in when so many deltas have been followed since, whenever it is ready: so the bits
    /// do not depend on how fast the thread is. One that is not ready then is waited for.
    int update_deltas = 2;
    /// Tension (MPa) per element of the session's first mesh, which cuts set free (pre_strain.h); empty: none.
    std::vector<Mat3> stress_of_element {};
};

} // namespace retractor::fem
