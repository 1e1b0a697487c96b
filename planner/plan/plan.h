#pragma once
// One approach from the labels to the measured field: mesh, cut, open, look. Units mm, N; frame patient LPS.

#include "mesh/base/job.h"
#include "planner/case/approach.h"
#include "planner/case/case.h"
#include "planner/case/patient.h"
#include "planner/plan/planned_field.h"

#include <vector>

namespace retractor::planner {

/// @throws InputError naming what does not go together, before anything long: check_solution(), a part with contact or
/// a distance that is negative or not finite, a check of nothing.
void check_local(const Case& planned_case, const SubmodelOptions& local);

/// Solved as the case's `solution` and `contact` say.
/// @throws InputError on a malformed approach, on a part that a hook reaches beyond, and on choices that do not go
/// together (check_local()); SolverError on a body that cannot be solved.
PlannedField plan_approach(
    Patient& patient, const Approach& approach, const Job& job = {}, const SubmodelOptions& local = {});

/// All approaches of the case, two at a time where the machine has the cores; results in the case's order.
std::vector<PlannedField> plan_all(Patient& patient, const Job& job = {}, const SubmodelOptions& local = {});

} // namespace retractor::planner
