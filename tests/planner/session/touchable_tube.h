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

/// "fem": four-node elements; "spheres": the body filled with some; "springs" are refused.
PalpationBackend tube_backend(std::shared_ptr<TubeControl> control);

} // namespace retractor::planner
