#include "planner/plan/opened_wall.h"

namespace retractor::planner {

bool is_usable(const fem::OpeningResult& opening)
{
    // Slivers inverted at the rims of hooks do not change a wound of many thousand elements; they are counted and
    // reported. With a larger share of inverted elements the numbers are wrong.
    constexpr double kMostInverted = 0.002;
    return opening.status == fem::OpeningStatus::converged
        || (opening.status == fem::OpeningStatus::inverted
            && opening.inverted_elements <= kMostInverted * static_cast<double>(opening.strain.size()));
}

} // namespace retractor::planner
