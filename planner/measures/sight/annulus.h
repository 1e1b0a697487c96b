#pragma once
// The plane of a valve's annulus, and how an opening lies to it. Units mm, degrees; frame patient LPS.

#include "mesh/base/geometry.h"
#include "planner/case/approach.h"

#include <optional>
#include <string>

namespace retractor::planner {

/// How an opening lies to a valve's annulus: 0 degrees is straight along the valve's axis.
struct AnnulusAccess {
    std::string message {}; ///< reason for missing numbers; empty: the numbers are there
    Vec3 centre = Vec3::Zero(), normal = Vec3::Zero(); ///< of the plane; the unit normal points towards the opening
    bool given = false; ///< the target gives the normal; false: the plane fits the site's surface
    double diameter_mm = 0.0; ///< mean over the site's surface
    double opening_off_axis_deg = 0.0; ///< angle between the normal and the line to the opening's middle
    double sight_off_axis_deg = 0.0; ///< angle between the normal and the line to the best eye
    double distance_mm = 0.0; ///< from the centre to the opening's middle
};

/// Whether a target is an annulus: a site with that name, or one with a normal.
bool is_annulus(const TargetSpec& target);

/// @param ring the site's surface: a ring round the annulus, or a patch where the normal is given
/// @param opening middle of the opening, and `eye` the best eye
AnnulusAccess annulus_access(const TargetSpec& target, const TriMesh& ring, const Vec3& opening, const Vec3& eye);

} // namespace retractor::planner
