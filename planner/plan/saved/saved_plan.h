#pragma once
// Plans on disk beside a case, so that a later session shows them without planning again. A file belongs to everything
// that its plan was made from, and is read only while the case holds the same. Of each approach the last few plans are
// kept, so that one that is tried and undone does not cost the plan before.

#include "planner/case/case.h"
#include "planner/plan/planned_field.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace retractor::planner {

/// What a plan is made from, in a text: the approach without its title, labels, images, materials, supports and
/// settings, the program and its version. How large a region and how fine a mesh a search chose is not in it: the plan
/// itself says it.
/// @throws InputError when there is no approach of this name
std::string plan_inputs(const Case& planned_case, std::string_view approach);

/// Path of the file: CASE/plans/APPROACH-XXXXXXXX.plan, with the CRC-32 of plan_inputs(); see approach_file().
/// @throws as plan_inputs()
std::filesystem::path plan_file(const Case& planned_case, std::string_view approach);

/// Plans of one approach that are kept.
inline constexpr std::size_t kKeptPlans = 4;

/// Writes the plan beside the case file, and removes the oldest beyond kKeptPlans. Pictures, tables and reports can be
/// made from it; the problem of elasticity and what only its solution needs are left out.
/// @param planned_case the case that was planned, with the approach as the case file has it
/// @throws IoError
void save_plan(const Case& planned_case, const PlannedField& field);

struct SavedPlan {
    PlannedField field;
    std::string date; ///< of the plan: UTC, "2026-11-22T12:58:03Z"
};

/// Reads the plan of an approach.
/// @returns nothing when there is none, or when it was made from something else than the case holds now
/// @throws InputError when the file is damaged; IoError when it cannot be read
std::optional<SavedPlan> read_saved_plan(const Case& planned_case, std::string_view approach);

} // namespace retractor::planner
