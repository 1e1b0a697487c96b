#pragma once
// What the window asks of the planner. The functions run on worker threads, at the same time if need be.

#include "mesh/base/job.h"
#include "planner/session/surgery_session.h"
#include "ui/workstation/planning/session_model.h"

#include <functional>
#include <string>

namespace retractor::ui {

struct PlanOutcome {
    enum class Status { planned, refused, cancelled };
    Status status = Status::planned;
    std::string message; ///< why it was refused
    FieldPictures field; ///< planned only
};

/// What the window lays out for the knife.
struct KnifeTable {
    planner::SurgerySetup table;
    Scene surroundings; ///< drawn, not cut; with the camera of the overview
};

struct PlanningBackend {
    /// The patient with the incision drawn on the closed skin.
    std::function<Scene(const planner::Approach&, const Job&)> closed_scene;
    std::function<PlanOutcome(const planner::Approach&, const Job&)> plan;
    /// The wall round the approach's incision, uncut, for the knife. Throws when there is none.
    std::function<KnifeTable(const planner::Approach&, const Job&)> operating_table;
};

/// The planner itself. Reads nothing before it is asked to; keeps what it has read.
PlanningBackend make_planning_backend(const planner::Case& planned_case);

} // namespace retractor::ui
