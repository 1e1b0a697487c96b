#pragma once
// Pictures of a case that need no plan. They serve a patient without an approach, or without a wall for one (a crop of
// the mediastinum). Units mm; frame patient LPS.

#include "planner/case/patient.h"
#include "ui/scene/scene.h"

#include <optional>
#include <string_view>

namespace retractor::ui {

/// The default target: the first label of role target, or else of role at-risk, that has voxels.
std::optional<planner::TargetSpec> default_target(planner::Patient& patient);

/// Draws one of two views:
/// - "slices": the three planes through the target, or through the middle of the labels when there is no target. Every
///   label is outlined in its own colour, the target in green. The legend lists the labels on the planes.
/// - "overview": bones, vessels and organs in space.
/// @throws InputError for another view, for slices without a CT, or for an unknown target
Picture case_picture(planner::Patient& patient, const std::optional<planner::TargetSpec>& target, std::string_view view,
    int width, int height);

} // namespace retractor::ui
