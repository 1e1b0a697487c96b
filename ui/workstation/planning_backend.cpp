#include "ui/workstation/planning_backend.h"

#include "fem/sparse_cholesky.h"
#include "planner/patient.h"
#include "planner/plan.h"
#include "ui/plan_scene/plan_scene.h"

#include <memory>

namespace retractor {

namespace {

    PlanOutcome planned_outcome(Patient& patient, const PlannedField& field)
    {
        PlanOutcome outcome;
        outcome.field.metrics = field.metrics;
        outcome.field.warning = field.message;
        outcome.field.surgeon = surgeon_scene(patient, field);
        outcome.field.overview = overview_scene(patient, field);
        if (patient.has_ct())
            outcome.field.slices = slice_scenes(patient, field.approach);
        // The numbers stand beside the picture.
        outcome.field.surgeon.legend.clear();
        outcome.field.overview.legend.clear();
        return outcome;
    }

} // namespace

PlanningBackend make_planning_backend(const Case& planned_case)
{
    set_blas_threads(1); // approaches are planned beside the window: BLAS must not take all cores
    const auto patient = std::make_shared<Patient>(planned_case);
    PlanningBackend backend;
    backend.closed_scene
        = [patient](const Approach& approach, const Job&) { return planning_scene(*patient, approach); };
    backend.plan = [patient](const Approach& approach, const Job& job) -> PlanOutcome {
        const PlannedField field = plan_approach(*patient, approach, job);
        switch (field.status) {
        case PlanStatus::done:
        case PlanStatus::not_converged:
            job.report("pictures", 0.0);
            return planned_outcome(*patient, field);
        case PlanStatus::cancelled:
            return { .status = PlanOutcome::Status::cancelled, .message = {}, .field = {} };
        case PlanStatus::nothing_to_mesh:
        case PlanStatus::cut_missed:
            break;
        }
        return { .status = PlanOutcome::Status::refused, .message = field.message, .field = {} };
    };
    return backend;
}

} // namespace retractor
