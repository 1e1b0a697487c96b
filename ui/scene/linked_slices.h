#pragma once
// Axial, coronal and sagittal slices that share a point, as radiologists read them: moving the point in one slice moves
// the other slices. Units mm; frame patient LPS.

#include "ui/scene/scene.h"

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::ui {

/// The Hounsfield values that a slice shows between black and white: `window_hu` wide round `level_hu`.
struct GreyWindow {
    const char* name;
    double window_hu, level_hu;
};

/// As radiologists set them; the first is how slices are made.
inline constexpr std::array kGreyWindows {
    GreyWindow { "Mediastinum", 500.0, 40.0 },
    GreyWindow { "Lung", 1500.0, -600.0 },
    GreyWindow { "Bone", 1800.0, 400.0 },
    GreyWindow { "Angiography", 700.0, 250.0 },
};

/// The axis across a plane of the patient: 0 sagittal, 1 coronal, 2 axial.
int axis_across(SlicePlane plane);

/// The distance between the planes of the image that lie closest to this plane.
double slice_step(const SliceItem& slice);

/// The point moved by a number of planes: axial towards the head, coronal to the front, sagittal to the patient's left.
/// The point stays within the image.
Vec3 stepped(const SliceItem& slice, double planes);

/// The place in the slice's plane that lies at a place of its picture: fractions of width and height from the lower
/// left corner. On a plane of the patient the place stays within the image. @pre the camera is parallel
Vec3 place_on_slice(const SliceItem& slice, const Camera& camera, double across, double up, double aspect);

/// A place in space as three short lines across the planes, in the planes' colours, drawn over everything.
std::vector<LineItem> mark_at(const Vec3& place, double half_length_mm);

/// Whether a scene is a slice that slices_at() moves.
bool is_linked_slice(const Scene& scene);

/// Name of the line of an incision.
inline constexpr std::string_view kIncisionName = "incision";

/// A slice through another point, with those parts of its lines (in space) that lie near its plane
/// (LineItem::near_slice_mm), put on the plane; the title says so where there is an incision. The outline of a ball (a
/// closed circle named "target") shrinks with the distance from its centre.
/// @pre is_linked_slice(scene)
Scene slice_with_lines(Scene scene, const Vec3& point);

/// The same scenes with slice_with_lines() through another point; thin lines show where the other planes lie, and the
/// first slice says place, Hounsfield value and label at the point.
/// @param names how labels are named; a label without a name is left out
std::vector<Scene> slices_at(std::vector<Scene> scenes, const Vec3& point, const std::map<Label, std::string>& names);

} // namespace retractor::ui
