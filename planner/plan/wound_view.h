#pragma once
// The view of the target through an opened wound. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/base/job.h"
#include "planner/case/patient.h"
#include "planner/measures/exposure.h"
#include "planner/plan/planned_field.h"
#include "planner/wall/field_geometry.h"

#include <string>

namespace retractor::planner {

/// What the surgeon sees through the opened wound.
struct WoundView {
    OpeningGeometry geometry;
    Exposure exposure;
    double working_distance_mm = 0.0;
    std::string message; ///< a remark
};

/// Measures the view of the target through the field's wound under a displacement: the field's own solution, or another
/// solution that the field is compared with. The samples on the target are the same for all of them, so that two views
/// differ by the wound and not by the samples.
/// @param displacement of the wall's vertices, n x 3, mm
/// @pre the field's remaining wall is known
/// @throws as measure_exposure() and wound_edges()
WoundView look_through(const PlannedField& field, const Points& displacement, Patient& patient, const Job& job);

} // namespace retractor::planner
