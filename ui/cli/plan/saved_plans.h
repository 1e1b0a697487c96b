#pragma once
// Plans beside a case, for commands that make or draw plans.

#include "planner/case/patient.h"
#include "planner/plan/plan.h"
#include "ui/cli/framework/command.h"

#include <map>
#include <string>
#include <vector>

namespace retractor::ui::cli {

/// Saves the plans of the case as its file has it. A plan that options or a draft changed is left out, and so is the
/// field of an approach that the case does not hold.
/// @param in_file the case without the command's options
/// @return a line that names the approaches, or says why nothing could be saved; empty where there was nothing to save
std::string save_plans(
    const planner::Case& in_file, const planner::Case& planned_case, const std::vector<planner::PlannedField>& fields);

struct DrawnFields {
    std::vector<planner::PlannedField> fields; ///< in the order of the approaches
    std::map<std::string, std::string> saved; ///< approaches that were not planned anew, and the date of their plan
    std::string remarks {}; ///< saved plans that could not be read, one line each
};

/// The saved plans of the patient's approaches; approaches without one, or with a damaged one, are planned.
/// @throws as plan_all() does
DrawnFields saved_or_planned(planner::Patient& patient, const Job& job, const planner::PlanChecks& checks);

} // namespace retractor::ui::cli
