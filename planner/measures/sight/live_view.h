#pragma once
// What is seen of the target through a wound while it is being opened by hand. Units mm, degrees; frame patient LPS.

#include "mesh/base/job.h"
#include "planner/case/approach.h"
#include "planner/case/patient.h"
#include "planner/measures/sight/exposure.h"
#include "planner/measures/sight/ray_scene.h"
#include "planner/wall/field_geometry.h"

#include <memory>
#include <vector>

namespace retractor::planner {

struct SeenNow {
    ExposureStatus status = ExposureStatus::done;
    double seen_fraction = 0.0; ///< by the best eye (SurgeonEye::seen_fraction)
    double sampling_error = 0.0; ///< standard error of seen_fraction from the number of points on the target
    double off_straight_deg = 0.0; ///< angle between the best line of sight and the straight view into the incision
    Vec3 eye = Vec3::Zero(), aim = Vec3::Zero(); ///< of the best eye
    double seconds = 0.0; ///< that the measurement took
};

/// The target and the organs of an approach, prepared once. Eyes stand as for a plan (eye_places_through()), about the
/// middle of the incision as it is planned.
class LiveView {
public:
    /// @throws InputError, IoError as organ_occluders() and Patient::target() do
    LiveView(Patient& patient, const Approach& approach);

    /// @param wall the wall as it is now
    /// @param around what else hides something now: the wall outside the model, hooks and blades; may be empty
    /// @throws InputError as RayScene() and best_eye() do
    SeenNow look(const TriMesh& wall, const TriMesh& around, const Job& job = {}) const;

private:
    std::shared_ptr<const TriMesh> target_;
    std::vector<Occluder> organs_;
    OpeningGeometry opening_; ///< middle, normal and direction of the incision
    ViewSpec view_;
};

} // namespace retractor::planner
