#pragma once
// Options of the nonlinear region while a hand drags hooks: the extent of the region and the work of a frame. Both are
// limited so that frames follow the hand. Units mm, N.

#include "fem/statics/nonlinear_region.h"

#include <cstdint>
#include <vector>

namespace retractor::fem {

struct DragRegion {
    std::vector<std::uint8_t> near; ///< one per element, 1 = nonlinear
    double within_mm = 0.0; ///< distance from the wound that the region reaches
};

/// The elements within 40 mm of the wound; within 30 or 20 mm where the number of elements would be too large to drag.
/// @param wound vertices of the lips, at rest
/// @throws InputError when even the elements within 20 mm are too many, and as elements_near()
DragRegion drag_region(const mesh::TetMesh& mesh, const Points& wound);

/// Options with corotational_linear elasticity, because cuts through patients leave flat elements.
/// @param load as NonlinearRegionOptions::load
NonlinearRegionOptions drag_options(Eigen::VectorXd load = {});

} // namespace retractor::fem
