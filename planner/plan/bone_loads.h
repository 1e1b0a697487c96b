#pragma once
// Measures what the bones of an opened wall bear, and whether the opening can be had without breaking one. Units mm, N,
// N m; frame patient LPS.

#include "mesh/image/volume.h"
#include "planner/anatomy/anatomy.h"
#include "planner/plan/opened_wound.h"
#include "planner/plan/planned_field.h"

#include <vector>

namespace retractor::planner {

/// The loads of ribs and sternum, in no order.
/// @param displacement at all nodes of the problem, three per node
/// @throws SolverError where moments cannot be had
std::vector<BoneMetrics> bone_metrics(const fem::ElasticProblem& problem, const SolverSettings& choice,
    const Eigen::VectorXd& displacement, const mesh::LabelTable& table, const AnatomicalFrame& frame);

/// Fills the field's bones with the moments in ribs and sternum and the loads of their joints (section_moments.h,
/// joint_loads.h), and sets whether the opening is attainable (bone_limits.h). Where the moments cannot be had, the
/// metrics give the reason instead. Adds a remark to the field's message where a bone would break.
/// @pre the metrics of the field's hooks are filled
void measure_bones(PlannedField& field, const OpenedWound& wound, const SolverSettings& choice,
    const mesh::LabelTable& table, const AnatomicalFrame& frame);

} // namespace retractor::planner
