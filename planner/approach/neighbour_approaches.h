#pragma once
// The approaches beside an approach: what if the surgeon goes one space higher or lower, or 20 mm along? Units mm;
// frame patient LPS.

#include "planner/case/approach.h"
#include "planner/case/patient.h"

#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// Distance by which a neighbour lies along the incision.
inline constexpr double kNeighbourStepMm = 20.0;

struct NeighbourApproach {
    std::string where; ///< "one space higher", "20 mm forwards"
    std::optional<Approach> approach {}; ///< with a name of its own; not set: there is none
    std::string refused {}; ///< reason for a missing approach
};

/// The same operation in the space above, in the space below, and kNeighbourStepMm along the incision to either side.
/// Template, length, division, target, views and what opens the wound are those of the approach. An incision that was
/// drawn is moved to the same angles of the other space. An incision that follows no space has neighbours along itself
/// only, a hemisternotomy in the spaces above and below only, and a median sternotomy has none.
/// Labels without landmarks have no spaces.
/// @param asked of the case, or of a planned field, whose hooks are the blades of its retractor
/// @throws InputError, IoError as Patient::labels() does
std::vector<NeighbourApproach> neighbours_of(Patient& patient, const Approach& asked);

} // namespace retractor::planner
