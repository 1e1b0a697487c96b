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

/// Checks the options before any long computation.
/// @throws InputError naming options that contradict each other: as check_solution() does; a part with contact, a
/// distance that is negative or not finite, or a check that has nothing to check
void check_local(const Case& planned_case, const SubmodelOptions& local);

/// Plans the approach with the case's `solution` and `contact`.
/// @throws InputError on a malformed approach, on a hook outside the part that is solved, and on options that
/// contradict each other (check_local()); SolverError on a body that cannot be solved
PlannedField plan_approach(
    Patient& patient, const Approach& approach, const Job& job = {}, const SubmodelOptions& local = {});

/// Plans all approaches of the case, two at a time where the machine has the cores. Results are in the case's order.
std::vector<PlannedField> plan_all(Patient& patient, const Job& job = {}, const SubmodelOptions& local = {});

} // namespace retractor::planner
