#pragma once
// From a planned field to plain scenes: what the surgeon sees through the incision, the patient from outside, and
// three slices with the incision drawn. Units mm; frame patient LPS.

#include "planner/case/patient.h"
#include "planner/plan/planned_field.h"
#include "ui/scene/scene.h"

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::ui {

/// Through the opening, from the central eye of the cone that the exposure was measured with.
Scene surgeon_scene(planner::Patient& patient, const planner::PlannedField& field);

/// The opened patient from outside.
Scene overview_scene(planner::Patient& patient, const planner::PlannedField& field);

/// Axial, coronal and sagittal planes through the target, with labels outlined and the incision drawn.
/// @throws InputError when the case has no CT.
std::vector<Scene> slice_scenes(planner::Patient& patient, const planner::Approach& approach);

/// The same without an approach; labels are outlined in the colours given. A target that is a sphere is drawn as its
/// outline.
std::vector<Scene> slice_scenes(
    planner::Patient& patient, const planner::TargetSpec& target, const std::map<Label, Color>& colors);

/// Through a point, with nothing to look at but the labels.
std::vector<Scene> slice_scenes(planner::Patient& patient, const Vec3& point, const std::map<Label, Color>& colors);

/// The slices of an approach side by side: what view_picture() gives for "slices", which needs no planned field.
Picture slices_picture(planner::Patient& patient, const planner::Approach& approach, int width, int height);

/// The closed patient with the incision drawn and the target showing through: before anything is cut.
Scene planning_scene(planner::Patient& patient, const planner::Approach& approach);

/// What a wall that the knife works on is seen with: the planned incision drawn on the skin and, behind the wall and
/// shining through it, the target. Neither the wall nor the body beyond it is in it.
Scene knife_surroundings(planner::Patient& patient, const planner::Approach& approach);

/// The body beyond the wall that is meshed for an approach, at rest, in fewer triangles; see unmeshed_wall_region().
TriMesh body_beyond(
    planner::Patient& patient, const planner::Approach& approach, const mesh::TetMesh& wall, const Job& job = {});

/// One view of a field as a picture: "surgeon", "overview" or "slices".
/// @throws InputError on another name.
Picture view_picture(
    planner::Patient& patient, const planner::PlannedField& field, std::string_view view, int width, int height);

} // namespace retractor::ui
