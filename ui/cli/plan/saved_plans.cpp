#include "ui/cli/plan/saved_plans.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "planner/plan/saved/saved_plan.h"
#include "ui/results/field_files.h"

#include <algorithm>
#include <utility>

namespace retractor::ui::cli {

namespace {

    bool has_approach(const planner::Case& planned_case, const std::string& name)
    {
        return std::any_of(planned_case.approaches.begin(), planned_case.approaches.end(),
            [&](const planner::Approach& approach) { return approach.name == name; });
    }

} // namespace

std::string save_plans(
    const planner::Case& in_file, const planner::Case& planned_case, const std::vector<planner::PlannedField>& fields)
{
    std::vector<std::string> saved;
    try {
        for (const planner::PlannedField& field : fields) {
            const std::string& name = field.approach.name;
            if (!planner::is_measured(field) || field.metrics.solution.draft || field.ended_by_time
                || !has_approach(in_file, name) || !has_approach(planned_case, name)
                || planner::plan_inputs(in_file, name) != planner::plan_inputs(planned_case, name))
                continue;
            planner::save_plan(planned_case, field);
            saved.push_back(name);
        }
    } catch (const IoError&) {
        return "the plans are not saved with the case: " + to_string(current_failure()) + "\n";
    }
    return saved.empty() ? std::string()
                         : "saved with the case, for retractor render and the window: " + joined(saved) + "\n";
}

DrawnFields saved_or_planned(planner::Patient& patient, const Job& job, const planner::PlanChecks& checks)
{
    const planner::Case& planned_case = patient.planned_case();
    DrawnFields drawn;
    std::map<std::string, planner::PlannedField> known;
    planner::Case rest = planned_case;
    rest.approaches.clear();
    for (const planner::Approach& approach : planned_case.approaches) {
        std::optional<planner::SavedPlan> saved;
        try {
            saved = planner::read_saved_plan(planned_case, approach.name);
        } catch (const Error&) {
            drawn.remarks += to_string(current_failure()) + "\n"; // it is planned again
        }
        if (!saved) {
            rest.approaches.push_back(approach);
            continue;
        }
        drawn.saved[approach.name] = saved->date;
        known[approach.name] = std::move(saved->field);
    }
    if (known.empty()) {
        drawn.fields = plan_all(patient, job, checks);
        return drawn;
    }
    if (!rest.approaches.empty()) {
        planner::Patient others(rest, job);
        for (planner::PlannedField& field : plan_all(others, job, checks)) {
            const std::string name = field.approach.name;
            known[name] = std::move(field);
        }
    }
    for (const planner::Approach& approach : planned_case.approaches)
        drawn.fields.push_back(std::move(known.at(approach.name)));
    return drawn;
}

} // namespace retractor::ui::cli
