#pragma once
// What a finger reaches, in a sentence for people.

#include "planner/measures/field_metrics.h"

#include <string>

namespace retractor::planner {

/// "A finger touches 12 %.", "A finger ends 27 mm before the aneurysm." or that no finger comes to the target.
std::string finger_text(const FieldMetrics& field);

} // namespace retractor::planner
