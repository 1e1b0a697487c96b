#pragma once
// The approach of an incision that a search has found. Units mm; frame patient LPS.

#include "planner/approach/approach_draft.h"
#include "planner/case/approach.h"
#include "planner/case/patient.h"
#include "planner/search/incision_search.h"

#include <string>

namespace retractor::planner {

/// The approach with this incision, as templates and drawn points make it. Its name is that of the place:
/// "left_space_4_110mm".
/// @throws InputError as approach_from_template(), approach_from_points() and opened_by() do, and where the incision
/// has no room for all of its length
Approach approach_of(Patient& patient, const FoundIncision& incision, const SearchRequest& request);

/// "left intercostal space 4, at the side, 110 mm": the place in words.
std::string place_in_words(const FoundIncision& incision);

} // namespace retractor::planner
