#pragma once
// A patient made of a few shapes, for tests of the window without the planner: a box of skin, a target behind the box,
// and a "plan" that removes the front of the box.

#include "ui/workstation/planning/planning_backend.h"

#include <atomic>
#include <filesystem>
#include <memory>
#include <set>
#include <string>

namespace retractor::test_support {

/// Approaches "median" and "lateral" on the front of the box, and "broken", which cannot be planned.
planner::Case synthetic_case();

/// Controls of the test while the window works, and counts of the backend's calls.
struct SyntheticControl {
    std::atomic<bool> hold { false }; ///< plans and palpations wait until this is false or they are cancelled
    std::filesystem::path cuts_folder; ///< folder for cuts by hand; empty: cuts are not kept
    std::set<std::string> saved_plans; ///< approaches with a plan of an earlier session; of "broken" it is damaged
    std::atomic<bool> incision_slices { false }; ///< approaches have a slice across the incision
    std::atomic<bool> hold_files { false }; ///< movies and reports wait until this is false or they are cancelled
    std::atomic<int> closed_made { 0 }, plans_made { 0 }, setups_made { 0 };
    std::atomic<std::size_t> hiding_triangles { 0 }; ///< of what lay round the wall at the last look
};

ui::PlanningBackend synthetic_backend(const std::shared_ptr<SyntheticControl>& control);

} // namespace retractor::test_support
