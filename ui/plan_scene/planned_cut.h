#pragma once
// The cut of an approach before anything is opened, as a sheet under the skin. Units mm; frame patient LPS.

#include "planner/case/patient.h"
#include "ui/scene/scene.h"

namespace retractor::ui {

/// Opacity of the body's wall where one looks through it.
inline constexpr double kSeeThroughOpacity = 0.2;

/// The outside view turned about the incision, towards the feet or the patient's left: seen along the blade, the cut is
/// a line.
Camera planned_cut_camera(const Camera& outside, const planner::Approach& approach);

/// What the blade passes, drawn over the bones that it divides: from the incision to its depth, and the strokes that
/// divide a space or the sternum beyond the skin; see find_division().
SurfaceItem planned_cut(planner::Patient& patient, planner::Approach approach);

/// The patient from outside before the cut: bones, targets and structures at risk through a see-through wall, and the
/// cut between them. With planned_cut_camera().
Scene planned_cut_scene(planner::Patient& patient, const planner::Approach& approach);

} // namespace retractor::ui
