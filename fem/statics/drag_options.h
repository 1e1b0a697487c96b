#pragma once
// The near field under a hand that drags hooks: how much of the tissue is nonlinear, and how near to equilibrium a
// frame comes, so that frames follow the hand. Units mm, N.

#include "fem/statics/nonlinear_region.h"

#include <cstdint>
#include <vector>

namespace retractor::fem {

struct DragRegion {
    std::vector<std::uint8_t> near; ///< one per element, 1 = nonlinear
    double within_mm = 0.0; ///< of the wound
};

/// Within 40 mm of the wound; nearer where that is more elements than can be dragged.
/// @param wound the vertices of its lips, at rest. @throws InputError where even those within 20 mm are too many, and
/// as elements_near() does.
DragRegion drag_region(const mesh::TetMesh& mesh, const Points& wound);

/// Bounded elasticity: cuts through patients leave flat elements. @param load as in NonlinearRegionOptions.
NonlinearRegionOptions drag_options(Eigen::VectorXd load = {});

} // namespace retractor::fem
