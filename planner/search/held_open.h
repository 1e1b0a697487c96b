#pragma once
// What holds a found incision open, and the hole that this leaves. Units mm; frame patient LPS.

#include "planner/approach/approach_draft.h"
#include "planner/measures/sight/aperture.h"
#include "planner/search/search_request.h"

#include <string>

namespace retractor::planner {

/// What opens this incision. Usual are a sternal spreader for the sternum, a small retractor for an incision between
/// ribs that is shorter than 100 mm, and a rib spreader for a longer one.
OpenedBy opening_of(const FoundIncision& incision, const SearchRequest& request);

/// Another retractor of the table that may open this incision as wide; empty: there is none, or the request says what
/// opens. Between ribs these are rib spreader and small retractor, at the sternum sternal and rib spreader.
std::string other_retractor(const FoundIncision& incision, const SearchRequest& request);

/// The hole between the faces of the two blades. They turn about their arms to the end of their play, because all that
/// they bear on lies below the arms, so that the hole narrows below the skin. Hooks do not turn, and their steel, which
/// is narrow, is left out.
/// @param wall_mm thickness of the wall
/// @throws InputError on an unknown SearchRequest::retractor
ApertureWidth hole_width(const FoundIncision& incision, double wall_mm, const SearchRequest& request);

} // namespace retractor::planner
