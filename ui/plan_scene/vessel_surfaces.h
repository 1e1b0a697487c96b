#pragma once
// Vessels and nerves whose places are assumed (planner::Case::assumed_vessels), as surfaces and lines of a scene. Units
// mm; frame patient LPS.

#include "planner/case/case.h"
#include "planner/plan/planned_field.h"
#include "ui/scene/scene.h"

#include <vector>

namespace retractor::ui {

/// All of them as they lie before any cut.
std::vector<SurfaceItem> vessel_surfaces(const planner::Case& planned_case);

/// Those near the incision, moved with the tissue of the opened wall. A vessel that the cut divides is drawn as two.
std::vector<SurfaceItem> vessel_surfaces(const planner::Case& planned_case, const planner::PlannedField& field);

/// As they lie before any cut, for slices: each slice shows where they pass through it.
std::vector<LineItem> vessel_lines(const planner::Case& planned_case);

/// Takes them out of a scene: nothing is computed of what they hide.
void remove_vessels(Scene& scene);

} // namespace retractor::ui
