#pragma once
// What brings a planned incision into the theatre: distances from landmarks that can be palpated, a ribbon to print,
// and a curve for 3D Slicer. Units mm; frame patient LPS.

#include "planner/anatomy/anatomy.h"
#include "planner/case/approach.h"
#include "planner/case/patient.h"

#include <string>
#include <vector>

namespace retractor::planner {

/// Straight distances from a landmark on the skin to the ends of the incision, as a caliper measures them.
struct LandmarkDistance {
    std::string landmark; ///< "jugular notch", "tip of the xiphoid"
    Vec3 at = Vec3::Zero(); ///< the place of the skin that is nearest to the bone, where it is felt
    double to_start_mm = 0.0, to_end_mm = 0.0;
};

/// The landmarks that the labels show; none where they show no sternum. @throws InputError, IoError as
/// Patient::labels()
std::vector<LandmarkDistance> landmark_distances(Patient& patient, const Approach& approach);

/// What to check on the skin: the side and distance of both ends from the midline, and "From the jugular notch 45 mm to
/// its start and 190 mm to its end, in a straight line.". Empty where the labels show no sternum.
/// @throws as landmark_distances()
std::vector<std::string> theatre_sentences(Patient& patient, const Approach& approach);

/// A closed ribbon on the skin along the incision, with a slit where the knife goes: a guide to print.
/// @param width_mm of the ribbon on each side of the slit, @param slit_mm width of the slit, @param thickness_mm height
/// over the skin; all > 0
TriMesh guide_ribbon(const Approach& approach, double width_mm = 6.0, double slit_mm = 1.5, double thickness_mm = 2.0);

/// The incision as a curve of 3D Slicer's markups (schema 1.0.3, JSON), in patient LPS.
std::string slicer_markup(const Approach& approach);

} // namespace retractor::planner
