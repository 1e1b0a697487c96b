#pragma once
// A coarse vessel to be palpated by tests, and tissues for it whose answers can be made wrong.

#include "planner/session/palpation_session.h"

#include <atomic>
#include <memory>

namespace retractor::planner {

/// A straight tube of 60 mm with the sites "centre" and "centre-opposite".
datasets::PalpationScene tube_scene();

struct TubeControl {
    bool pulse = false; ///< else the pressure is the rest state's, and forces are steady
    bool can_be_sick = false; ///< it is then no CondensedTissue any more: nothing to be edited
    std::atomic<bool> sick { false }; ///< answers NaN
};

/// The direction of the tube, unit.
Vec3 tube_axis();

/// What reaches through a slit: a finger and an instrument. The slit lies across the tube, in a plate that lies before
/// the site "centre". Its lips are "left lip" and "right lip", which lies towards tube_axis().
/// @param width_mm of the slit
std::vector<ThroughOpening> slit_before_tube(double width_mm);

/// "fem": four-node elements; "spheres": the body filled with some; "springs" are refused.
PalpationBackend tube_backend(std::shared_ptr<TubeControl> control);

} // namespace retractor::planner
