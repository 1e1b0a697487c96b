#pragma once
// What was asked of the hooks of a field, beside what they reached. Units mm, N.

#include "planner/measures/field_metrics.h"

#include <optional>
#include <string>

namespace retractor::planner {

/// Distance between opposite hooks, as the opening that make_hooks() takes: the mean way of the hooks of one lip and
/// that of the other.
struct HookOpening {
    std::optional<double> asked_mm; ///< none where no hook was told a place: they pull with forces
    double reached_mm = 0.0; ///< of the tissue under the hooks
};

/// Hooks that pull with a force are no part of what was asked.
HookOpening hook_opening(const FieldMetrics& field);

/// "60.0 mm", "60.0 mm, at most 150.0 N per hook", "2 hooks pull with 40.0 N": what the case asks for.
std::string asked_text(const FieldMetrics& field);

/// Whether a hook has a limit at which it yields.
bool has_limited_hooks(const FieldMetrics& field);

} // namespace retractor::planner
