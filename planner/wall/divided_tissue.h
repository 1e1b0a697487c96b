#pragma once
// Tissue that is divided beyond the ends of the skin incision, under intact skin. Units mm.

#include <string>
#include <vector>

namespace retractor::planner {

/// What the division of an intercostal space or of the sternum severed.
struct DividedTissue {
    std::vector<std::string> labels {}; ///< labels that the strokes sever
    double length_mm = 0.0; ///< whole length of the division: the incision and all ways beyond it
    double forwards_mm = 0.0, backwards_mm = 0.0; ///< beyond the incision's ends, along the space
    double right_mm = 0.0, left_mm = 0.0; ///< across the sternum, to the patient's right and left
    double severed_mm2 = 0.0; ///< area that the strokes opened, one side, at rest
    std::string words {}; ///< the space, and the reasons why the division ends where it does

    /// The length beyond the incision.
    double beyond_mm() const { return forwards_mm + backwards_mm + right_mm + left_mm; }
};

} // namespace retractor::planner
