#pragma once
// The cut of an approach before anything is opened, as a sheet under the skin. Units mm; frame patient LPS.

#include "planner/case/patient.h"
#include "ui/scene/scene.h"

#include <vector>

namespace retractor::ui {

/// Opacity of the body's wall where one looks through it.
inline constexpr double kSeeThroughOpacity = 0.2;

/// The outside view turned about the incision, towards the feet or the patient's left: seen along the blade, the cut is
/// a line.
Camera planned_cut_camera(const Camera& outside, const planner::Approach& approach);

/// What the blade passes, drawn over the bones that it divides: from the incision to its depth, and the strokes that
/// divide a space or the sternum beyond the skin; see find_division().
SurfaceItem planned_cut(planner::Patient& patient, planner::Approach approach);

/// The patient from outside before the cut: the anatomy through a see-through wall, and the cut in it. With
/// planned_cut_camera(). @param anatomy as anatomy_surfaces()
Scene planned_cut_scene(
    planner::Patient& patient, const planner::Approach& approach, const std::vector<SurfaceItem>& anatomy);

} // namespace retractor::ui
