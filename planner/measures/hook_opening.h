#pragma once
// Compares the prescribed opening of the hooks with the opening that they reached. Units mm, N.

#include "planner/measures/field_metrics.h"

#include <optional>
#include <string>

namespace retractor::planner {

/// Distance between opposite hooks, as make_hooks() takes it: the mean motion of the hooks of one lip plus the mean
/// motion of the hooks of the other.
struct HookOpening {
    std::optional<double> asked_mm; ///< prescribed opening; not set where all hooks pull with forces
    double reached_mm = 0.0; ///< motion of the tissue under the hooks
};

/// Hooks that pull with a force do not count in asked_mm.
HookOpening hook_opening(const FieldMetrics& field);

/// Text of what the case prescribes: "60.0 mm", "60.0 mm, at most 150.0 N per hook", "2 hooks pull with 40.0 N".
std::string asked_text(const FieldMetrics& field);

/// Whether a hook has a force limit.
bool has_limited_hooks(const FieldMetrics& field);

} // namespace retractor::planner
