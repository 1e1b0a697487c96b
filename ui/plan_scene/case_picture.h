#pragma once
// Pictures of a case that need no plan: for a patient who has no approach yet, or no wall to plan one through (a crop
// of the mediastinum). Units mm; frame patient LPS.

#include "planner/case/patient.h"
#include "ui/scene/scene.h"

#include <optional>
#include <string_view>

namespace retractor::ui {

/// What to look at when nobody says: the first label of role target, else of role at-risk, that has voxels.
std::optional<planner::TargetSpec> default_target(planner::Patient& patient);

/// "slices": the three planes through the target (without one, through the middle of what is labelled), every label
/// outlined in its own colour, the target in green, with a legend of what the planes meet. "overview": bones, vessels
/// and organs in space.
/// @throws InputError for another view, for slices without a CT, or an unknown target.
Picture case_picture(planner::Patient& patient, const std::optional<planner::TargetSpec>& target, std::string_view view,
    int width, int height);

} // namespace retractor::ui
