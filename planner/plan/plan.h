#pragma once
// Plans one approach, from the labels to the measured field: mesh the wall, cut it, open the wound, measure the view.
// Units mm, N; frame patient LPS.

#include "mesh/base/job.h"
#include "planner/case/approach.h"
#include "planner/case/case.h"
#include "planner/case/patient.h"
#include "planner/case/solver_settings.h"
#include "planner/case/stiffness_factors.h"
#include "planner/plan/found_region.h"
#include "planner/plan/planned_field.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::planner {

/// Ours: the openings of the phantom's and the patient's approaches take 1 to 8 minutes on two cores, and a busy
/// machine takes a few times as long.
inline constexpr double kMostOpeningS = 1800.0;

/// What a plan computes besides the opened wound.
struct PlanChecks {
    /// Also solves the whole wall nonlinearly, and reports the difference from the solution with a linear region.
    bool linear_region = false;
    bool error_bars = true; ///< Estimates the discretisation error. A draft does without.
    bool draft = false; ///< Records that the caller asked for a quick plan (SolutionMetrics::draft); changes nothing.
    /// plan_in_region() plans on finer meshes until the error bars are this small (accurate_plan.h); not set: once.
    /// plan_approach() plans once.
    std::optional<AccuracyGoal> accuracy {};
    /// Also solves the largest uninjured opening where a bone would break (uninjured_opening.h); plan_all() then plans
    /// such an approach once more with this bone divided, and puts this field behind that of the approach.
    bool injury_options = false;
    /// plan_in_region() and plan_samples() find the region of an approach that gives none, once for all its meshes;
    /// otherwise the region is kFirstRegionMm. plan_approach() takes the region as it is.
    bool find_region = false;
    /// A wall that lies within this distance of the incision is meshed whole, mm, where the plan's edges are as long as
    /// a draft's, 12 mm. Of a larger wall, or with shorter edges, drafts show how much moves (found_region.h).
    double whole_wall_mm = kWholeWallMm;
    /// Memory that one plan may take, bytes; not set: all that is available. plan_all() divides what is available
    /// among the plans that run at the same time.
    std::optional<double> memory_bytes {};
    /// Time for one search of the opened wound's equilibrium, s. The plan ends after it with the state that the search
    /// had reached (end_unfinished()).
    double opening_time_s = kMostOpeningS;
};

/// Checks the case's settings before any long computation.
/// @throws InputError as check_solution(), check_accuracy(), check_pressures() and check_plausible(), on a check of the
/// linear region without one, and on an accuracy without error bars
void check_plan(const Case& planned_case, const PlanChecks& checks);

/// Plans one approach, once, with the case's solver settings (`solution`, `contact`). Before meshing, the job's
/// progress tells the forecast of tetrahedra, time and memory.
/// @throws InputError on a malformed or implausible approach and on contradictory settings (check_plan());
/// MemoryRefusal (an InputError) on a mesh whose plan does not fit into the memory; SolverError on a body that cannot
/// be solved
PlannedField plan_approach(
    Patient& patient, const Approach& approach, const Job& job = {}, const PlanChecks& checks = {});

/// Plans one approach as plan_approach() does, with its region found and as accurately as the checks ask. A region
/// whose plan does not fit the memory is made smaller.
/// @throws as plan_approach()
PlannedField plan_in_region(
    Patient& patient, const Approach& approach, const Job& job = {}, const PlanChecks& checks = {});

/// One of several plans, of which others may have an answer where this one has none.
struct PlanAttempt {
    PlannedField field;
    std::string failure {}; ///< why there is no field; empty: there is one
};

/// Plans one approach once for each set of stiffness. The wall is meshed and cut once. It is opened first with the
/// stiffness of the case, and each sample begins at this opening (open_wound()). A sample therefore takes a fraction of
/// the time of plan_approach(). Both end within the same residual and balance of the retractor. Their forces differ by
/// a few percent, or more where lips can slide into several balances (docs/method/elasticity.md).
/// @param samples an empty one is the case as it is
/// @param on_planned called with the number of each sample as soon as it is planned: empty ones first, the others in
/// order
/// @throws as plan_approach() from the mesh, the cut and the opening with the stiffness of the case
/// @post a cancelled job ends without the samples that remain; the patient has the stiffness of one of the samples, or
/// of the case
void plan_samples(Patient& patient, const Approach& approach, std::span<const StiffnessFactors> samples,
    const std::function<void(std::size_t sample, PlanAttempt planned)>& on_planned, const Job& job = {},
    const PlanChecks& checks = {});

/// Plans all approaches of the case, two at a time on several cores. The results have the case's order; see
/// PlanChecks::injury_options for fields that are added.
/// @throws as plan_approach(), naming the approach
std::vector<PlannedField> plan_all(Patient& patient, const Job& job = {}, const PlanChecks& checks = {});

/// The same for approaches of which some may be impossible: one attempt for each approach of the case, in its order.
/// Plans with a divided bone (PlanChecks::injury_options) are not made.
/// @throws whatever is neither InputError nor SolverError
std::vector<PlanAttempt> plan_each(Patient& patient, const Job& job = {}, const PlanChecks& checks = {});

} // namespace retractor::planner
