#pragma once
// Explains in a surgeon's words why the target is seen or hidden, from what the rays met.

#include "planner/anatomy/anatomy.h"

#include <string>

namespace retractor::planner {

struct PlannedField;

/// A few sentences: the share that is seen, the side of the hidden part, the tissue and bone in the way, and the limits
/// of the opening. The text states no cause that the numbers do not show.
std::string explain_field(const PlannedField& field, const AnatomicalFrame& frame);

} // namespace retractor::planner
