#pragma once
// The view of the target through an opened wound. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/base/job.h"
#include "planner/anatomy/deflated_lung.h"
#include "planner/approach/hook_mesh.h"
#include "planner/case/patient.h"
#include "planner/measures/sight/exposure.h"
#include "planner/measures/sight/surgeon_eye.h"
#include "planner/plan/planned_field.h"
#include "planner/wall/field_geometry.h"

#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// What the surgeon sees through the opened wound.
struct WoundView {
    OpeningGeometry geometry;
    SurgeonEye best; ///< the best place of the eye
    Exposure exposure; ///< all eyes of the cone
    double working_distance_mm = 0.0;
    OpeningFromTarget from_target; ///< from the place that the best eye aims at
    std::string message; ///< a remark
};

/// Whether a label is of an organ that stays in place and blocks the view. The target does not, and neither does the
/// organ that contains a spherical target, because this organ is operated on. The organ of a site does: its other parts
/// hide the site.
bool blocks_view(const mesh::LabelInfo& label, const Approach& approach, Patient& patient);

/// Where the organs are.
struct OrganPlaces {
    Vec3 by = Vec3::Zero(); ///< motion of the target, of all organs and of the faces where the image ends, mm
    /// Of their volume that lungs held aside keep; 0: these lungs are left out, as where there is no incision yet.
    double lung_share = kDeflatedLungShare;
};

/// The organs that stay in place and block the view, lungs that are held aside, deflated, and the faces where the image
/// ends.
std::vector<Occluder> organ_occluders(const Approach& approach, Patient& patient, const OrganPlaces& places = {});

/// The places that the eyes of a view can take: the cone through the opening, from which a surgeon leans in and back.
/// @throws InputError as cone_through_opening() does
EyePlaces eye_places_through(const OpeningGeometry& opening, const Vec3& aim, const ViewSpec& eyes);

/// The hooks or blades of a field where they stand under a displacement.
std::vector<HookShape> placed_hooks(
    const PlannedField& field, const Points& displacement, const OpeningGeometry& opening);

/// Measures the view of the target through the field's wound under a displacement of the wall's vertices (n x 3, mm).
/// Wall, hooks and organs that stay block it.
/// @pre the field's remaining wall is known
/// @throws as measure_exposure(), best_eye() and wound_edges()
WoundView look_through(const PlannedField& field, const Points& displacement, Patient& patient, const Job& job);

/// SurgeonEye::seen_fraction alone, through the wound under another solution that the field is compared with. The
/// samples on the target are the same for all solutions, so that two views differ by the wound and not by the samples.
/// @param up EyePlaces::up
double seen_from_best_eye(const PlannedField& field, const Points& displacement, Patient& patient, const Job& job,
    const OrganPlaces& places = {}, const std::optional<Vec3>& up = {});

} // namespace retractor::planner
