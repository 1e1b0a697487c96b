#pragma once
// A patient made of a few shapes, for a window that needs no planner: a box of skin, a target behind it, and a "plan"
// that takes the box's front away.

#include "ui/workstation/planning/planning_backend.h"

#include <atomic>
#include <filesystem>
#include <memory>

namespace retractor::test_support {

/// Approaches "median" and "lateral" on the front of the box, and "broken", which cannot be planned.
planner::Case synthetic_case();

/// What the test holds in its hand while the window works.
struct SyntheticControl {
    std::atomic<bool> hold { false }; ///< plans wait until this is false, or until they are cancelled
    std::filesystem::path cuts_folder; ///< where cuts by hand are kept; empty: nowhere
    std::atomic<int> closed_made { 0 }, plans_made { 0 }, tables_laid { 0 };
};

ui::PlanningBackend synthetic_backend(const std::shared_ptr<SyntheticControl>& control);

} // namespace retractor::test_support
