#include "ui/workstation/planning/planning_backend.h"

#include "mesh/base/error.h"
#include "mesh/base/text.h"
#include "mesh/generation/hybrid_model.h"
#include "planner/case/case.h"
#include "planner/case/patient.h"
#include "planner/plan/plan.h"
#include "planner/session/kept_cuts.h"
#include "planner/wall/supports.h"
#include "planner/wall/wall_cut.h"
#include "ui/plan_scene/plan_scene.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

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

    /// What the plan does otherwise than the hooks under the knife; empty: nothing to say.
    std::string not_as_planned(const Case& planned_case)
    {
        std::string text;
        if (under_pressure(planned_case))
            remark(text, "the pressure on the wall acts in plans, not under the knife");
        const std::vector<Material> here = materials_as_solved(planned_case, ElementKind::p1),
                                    planned = materials_as_solved(planned_case);
        const auto stiffer = std::find_if(planned.begin(), planned.end(), [&](const Material& material) {
            return material.poissons_ratio > here[static_cast<std::size_t>(&material - planned.data())].poissons_ratio;
        });
        if (stiffer != planned.end())
            remark(text,
                "hooks under the knife take Poisson's ratios as at most "
                    + in_words(largest_poissons_ratio(ElementKind::p1), 2) + ", plans of this case as they are ("
                    + stiffer->name + " " + in_words(stiffer->poissons_ratio, 2) + ")");
        return text;
    }

    /// The wall is meshed as plan_approach() meshes it: the same elements are cut by hand and planned.
    KnifeTable lay_table(Patient& patient, const Approach& approach, const Job& job)
    {
        check_approach(approach);
        const Case& planned_case = patient.planned_case();
        const auto labels = patient.labels();
        const MeshSizing sizing = mesh_sizing_of(approach, planned_case.label_table);
        HybridModel model = build_hybrid_model(*labels, sizing, job);
        if (model.status != MeshStatus::done)
            throw InputError(
                model.message.empty() ? "there is no wall to cut" : model.message, "approach " + approach.name);
        KnifeTable laid;
        OperatingTable& table = laid.table;
        Supports supports = supports_of(model.wall, *labels, planned_case, sizing);
        table.held = std::move(supports.fixed);
        table.cut_off = cut_off_vertices(model.wall, *labels);
        table.bedded = std::move(supports.bedded);
        table.approach = approach;
        table.labels = planned_case.label_table;
        table.journal = cuts_journal(planned_case.file(), approach.name);
        table.materials = materials_as_solved(planned_case, ElementKind::p1);
        table.caution = not_as_planned(planned_case);
        Vec3 inward = Vec3::Zero();
        for (const Vec3& direction : approach.directions)
            inward += direction;
        table.outward = -inward.normalized();
        laid.surroundings = knife_surroundings(patient, approach);
        table.beyond = std::make_shared<const TriMesh>(body_beyond(patient, approach, model.wall, job));
        table.region = { .corridor = sizing.corridor, .meshed_mm = sizing.region_mm };
        table.wall = std::move(model.wall);
        return laid;
    }

} // namespace

PlanningBackend make_planning_backend(const Case& planned_case)
{
    const auto patient = std::make_shared<Patient>(planned_case);
    PlanningBackend backend;
    backend.closed_scene
        = [patient](const Approach& approach, const Job&) { return planning_scene(*patient, approach); };
    backend.operating_table
        = [patient](const Approach& approach, const Job& job) { return lay_table(*patient, approach, job); };
    backend.plan = [patient](const Approach& approach, const Job& job) -> PlanOutcome {
        const PlannedField field = plan_approach(*patient, approach, job);
        switch (field.status) {
        case PlanStatus::done:
        case PlanStatus::not_converged:
        case PlanStatus::inverted:
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
