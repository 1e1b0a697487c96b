#pragma once
// Makes plain scenes from a planned field: the surgeon's view through the incision, the patient from outside, and three
// slices with the incision. Units mm; frame patient LPS.

#include "planner/case/patient.h"
#include "planner/decision/decisions.h"
#include "planner/plan/planned_field.h"
#include "ui/scene/scene.h"

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::ui {

/// The name of each label, with "(estimated)" behind those that the image does not show.
std::map<Label, std::string> label_names(const planner::Case& planned_case);

/// Names of surfaces in the scenes of a field.
inline constexpr std::string_view kBodyName = "body", kWallName = "chest wall",
                                  kBeyondName = "chest wall beyond the model", kImageEndName = "end of the image";

/// Name of the line of the cut on slices along and across the incision.
inline constexpr std::string_view kCutName = "cut";

/// The boundary of the field's wall under a displacement of its vertices, as pictures draw it: labels of the body's
/// layers, and no rim. Every displacement gives the same triangles.
TriMesh drawn_wall(planner::Patient& patient, const planner::PlannedField& field, const Points& displacement);

/// The wall beyond the model at rest. PlannedField::remaining_wall has the same triangles, moved by the opening.
TriMesh remaining_wall_at_rest(planner::Patient& patient, const planner::PlannedField& field);

/// The view through the opening from the best place of the eye, for which the share seen is measured.
Scene surgeon_scene(planner::Patient& patient, const planner::PlannedField& field);

/// The same view without labels that are drawn in another way, such as a structure that is palpated through the wound.
Scene surgeon_scene_without(
    planner::Patient& patient, const planner::PlannedField& field, const std::vector<std::string>& labels);

/// The camera of a kept view.
inline Camera camera_of(const planner::NamedView& view)
{
    return { .eye = view.eye, .aim = view.aim, .up = view.up, .view_angle_deg = view.view_angle_deg };
}

/// The lines of a legend that say what is only estimated: for pictures beside which the numbers stand.
std::vector<LegendLine> estimated_lines(std::vector<LegendLine> legend);

/// The opened patient from outside.
Scene overview_scene(planner::Patient& patient, const planner::PlannedField& field);

/// Axial, coronal and sagittal planes through the target, with labels outlined. The incision is a line in space, of
/// which slice_with_lines() takes what lies near a slice.
/// @throws InputError when the case has no CT
std::vector<Scene> slice_scenes(planner::Patient& patient, const planner::Approach& approach);

/// The plane along the incision and the plane across its middle, with the cut to its depth. @throws InputError when the
/// case has no CT
std::vector<Scene> incision_slice_scenes(planner::Patient& patient, const planner::Approach& approach);

/// Slices without an approach. Labels are outlined in the given colours. A spherical target is drawn as its outline.
std::vector<Scene> slice_scenes(
    planner::Patient& patient, const planner::TargetSpec& target, const std::map<Label, Color>& colors);

/// Slices through a point, without a target.
std::vector<Scene> slice_scenes(planner::Patient& patient, const Vec3& point, const std::map<Label, Color>& colors);

/// The slices of an approach side by side, through the target above and through the incision below, as view_picture()
/// makes them for "slices"; no planned field is needed.
Picture slices_picture(planner::Patient& patient, const planner::Approach& approach, int width, int height);

/// Bones, targets, structures at risk and assumed vessels as they lie in the CT, to be seen through the wall; see
/// label_surfaces() and vessel_surfaces().
std::vector<SurfaceItem> anatomy_surfaces(planner::Patient& patient, const Job& job = {});

/// The patient without an approach, from the front and from outside.
Scene patient_scene(planner::Patient& patient);

/// Slices through the middle of the labels, for a patient without an approach. @throws InputError when the case has no
/// CT
std::vector<Scene> patient_slices(planner::Patient& patient);

/// The patient before any cut, with the incision on the skin and the target shining through.
Scene planning_scene(planner::Patient& patient, const planner::Approach& approach);

/// The surroundings of a wall that the knife cuts: the planned incision on the skin, the organs behind the wall as in a
/// plan and, shining through the wall, the target. The scene contains neither the wall nor the body outside it.
Scene knife_surroundings(planner::Patient& patient, const planner::Approach& approach);

/// The body outside the wall that is meshed for an approach, at rest, with fewer triangles; see unmeshed_wall_region().
/// @param rim_mm width of the wall's rim to which the surface is fitted, so that no gap shows there
TriMesh body_beyond(planner::Patient& patient, const planner::Approach& approach, const mesh::TetMesh& wall,
    double rim_mm, const Job& job = {});

/// One view of a field as a picture: "surgeon", "overview" or "slices".
/// @throws InputError on another name
Picture view_picture(
    planner::Patient& patient, const planner::PlannedField& field, std::string_view view, int width, int height);

} // namespace retractor::ui
