#pragma once
// Why a field is as it is, in words a surgeon would use, from what the rays met.

#include "planner/anatomy/anatomy.h"

#include <string>

namespace retractor::planner {

struct PlannedField;

/// A few sentences: how much is seen, on which side the hidden part lies, what hides it, which bone is in the way,
/// what limits the opening. States no cause that the numbers do not show.
std::string explain_field(const PlannedField& field, const AnatomicalFrame& frame);

} // namespace retractor::planner
