#pragma once
// Tissue that is divided beyond the ends of the skin incision. Units mm.

#include <string>
#include <vector>

namespace retractor::planner {

/// What the division of an intercostal space severed.
struct DividedTissue {
    std::vector<std::string> labels {}; ///< labels that the strokes sever
    double length_mm = 0.0; ///< whole length of the division: the incision and both ways beyond it
    double forwards_mm = 0.0, backwards_mm = 0.0; ///< beyond the incision's ends, along the space
    double severed_mm2 = 0.0; ///< area that the strokes opened, one side, at rest
    std::string words {}; ///< the space, and the reasons why the division ends where it does
};

} // namespace retractor::planner
