#pragma once
// Tissue that ablations, or the removal of loose pieces, take out of the wall. Units mm.

#include <string>

namespace retractor::planner {

/// One portion of removed tissue.
struct RemovedTissue {
    std::string what; ///< description: "rib_left_5 between -10 and 10 mm across the incision", "a loose piece", ...
    std::string label;
    double volume_mm3 = 0.0;
};

} // namespace retractor::planner
