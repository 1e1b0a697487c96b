#pragma once
// Plans one approach, from the labels to the measured field: mesh the wall, cut it, open the wound, measure the view.
// Units mm, N; frame patient LPS.

#include "mesh/base/job.h"
#include "planner/case/approach.h"
#include "planner/case/case.h"
#include "planner/case/patient.h"
#include "planner/plan/planned_field.h"

#include <vector>

namespace retractor::planner {

/// @param check_far as plan_approach() takes it. @throws InputError naming what does not go together, before anything
/// long: check_solution(), check_pressures(), a check where no far field is linear.
void check_plan(const Case& planned_case, bool check_far);

/// Solved as the case's `solution` and `contact` say.
/// @param check_far where the case's solution is linear far from the lips: also solves all of the wall nonlinearly and
/// states the difference.
/// @throws InputError on a malformed approach and on choices that do not go together (check_plan()); SolverError on a
/// body that cannot be solved.
PlannedField plan_approach(Patient& patient, const Approach& approach, const Job& job = {}, bool check_far = false);

/// All approaches of the case, two at a time where the machine has the cores; results in the case's order.
std::vector<PlannedField> plan_all(Patient& patient, const Job& job = {}, bool check_far = false);

} // namespace retractor::planner
