#pragma once
// What plan, render and demo say in the terminal about planned fields.

#include "planner/plan/planned_field.h"

#include <string>
#include <vector>

namespace retractor::ui::cli {

/// A table for people, with the approaches that could not be planned and the reasons.
std::string field_table(const std::vector<planner::PlannedField>& fields);

/// Exit code: 0 when every field is an answer; 1 when a field is refused, did not converge or is not to be believed, or
/// a requested second opinion does not agree. Injury, of a rib or of skin, is an answer.
int exit_code_of(const std::vector<planner::PlannedField>& fields);

} // namespace retractor::ui::cli
