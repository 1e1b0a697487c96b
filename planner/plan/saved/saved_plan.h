#pragma once
// Plans on disk beside a case, one file per approach, so that a later session shows them without planning again. A file
// belongs to everything that its plan was made from. When any of this changes, the file is left alone and not read.

#include "planner/case/case.h"
#include "planner/plan/planned_field.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace retractor::planner {

/// Path of the file: CASE/plans/APPROACH.plan; see approach_file().
std::filesystem::path plan_file(const std::filesystem::path& case_file, std::string_view approach);

/// Everything that a plan is made from, in a text: the approach, labels, images, materials, supports and settings, the
/// program and its version. Two equal texts mean equal plans.
/// @throws InputError when there is no approach of this name
std::string plan_inputs(const Case& planned_case, std::string_view approach);

/// Writes the plan beside the case file. Pictures, tables and reports can be made from it; the problem of elasticity
/// and what only its solution needs are left out.
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
