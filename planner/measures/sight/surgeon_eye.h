#pragma once
// What a surgeon sees from the best place that the eye can take, with one eye and with two, and what two instruments
// reach. Units mm, degrees; frame patient LPS.
//
// A part of the target counts as seen where the (middle) eye meets its surface at less than kLargestIncidenceDeg: what
// is seen more obliquely cannot be operated on. The three fractions are of the largest area that any of the places
// shows at this incidence when the wall is removed, so that 1 means: the wall hides nothing.

#include "planner/measures/sight/exposure.h"
#include "planner/wall/field_geometry.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace retractor::planner {

/// Largest angle between line of sight and the surface's normal at which a place counts as seen, degrees (ours).
inline constexpr double kLargestIncidenceDeg = 60.0;
/// Distance of the pupils, mm: the mean of adults is 63 to 65 [Dodgson 2004, doi 10.1117/12.529999].
inline constexpr double kEyesApartMm = 64.0;

/// A surgeon at the table looks down at the wound at this angle at least, degrees below the horizontal (ours).
inline constexpr double kLowestSightDeg = 15.0;

/// Where an eye may be: in the cone's directions from its aim, between two distances.
struct EyePlaces {
    ViewCone cone;
    double nearest_mm = 0.0, farthest_mm = 0.0; ///< from cone.aim
    /// Away from the floor, unit: the eye looks down by kLowestSightDeg at least. What lower eyes would see counts in
    /// the bound only. Not set: the eye is anywhere in the cone.
    std::optional<Vec3> up {};
};

struct SurgeonEye {
    ExposureStatus status = ExposureStatus::done;
    Vec3 eye = Vec3::Zero(); ///< the central eye where no place sees anything
    Vec3 aim = Vec3::Zero(); ///< a place on the target: the middle of what is seen; cone.aim where nothing is
    double seen_fraction = 0.0; ///< of the bound
    double bound_area_mm2 = 0.0; ///< the largest area that any place shows with the wall removed
    /// Share of the target in a flat picture from here towards `aim`: projected area that is seen, at any incidence,
    /// over that of the target alone.
    double picture_share = 0.0;
    double incidence_deg = 0.0; ///< mean over what is seen
    /// Seen by two eyes round this place, with light from between them; the better of several turns of the head.
    double two_eyes_fraction = 0.0;
    double two_instruments_fraction = 0.0; ///< seen, and within reach of two shafts at once
    double finger_fraction = 0.0; ///< touched by a finger, seen or not; at most 1
    std::optional<double> finger_lacks_mm {}; ///< FingerReach::lacks_mm
    double freedom_mm2 = 0.0; ///< surgical_freedom_mm2() at `aim`
    /// Indices of the samples that two instruments reach (of those that are seen), and that a finger touches.
    std::vector<std::uint32_t> two_instruments_reach {}, finger_touches {};
    /// What hides the target first from here: shares of what the target alone would show at this incidence. Largest
    /// first.
    std::vector<SightShare> hidden_by {};
};

/// Where to look on the target: the middle of what is seen from the middle of the opening with the wall removed, or of
/// what organs hide; on the target's surface, so that the eye does not look beside a bent vessel.
Vec3 aim_through(const RayScene& scene, const OpeningGeometry& opening, const std::vector<SurfaceSample>& samples);

/// Finds the place that sees most of the target: all directions of the cone at three distances, then steps from the
/// best of them that are halved until they are small. Places inside a closed body are left out.
/// @param samples of the scene's target
/// @throws InputError on a bad cone, a direction that is not of length 1, or distances that are not positive and in
/// order
SurgeonEye best_eye(
    const RayScene& scene, const EyePlaces& places, const std::vector<SurfaceSample>& samples, const Job& job = {});

/// Adds what two eyes see round the best place, and what two instruments reach through the opening.
void add_two_eyes_and_instruments(SurgeonEye& best, const RayScene& scene, const OpeningGeometry& opening,
    const std::vector<SurfaceSample>& samples, const Job& job = {});

/// Adds what a finger touches through the opening, and the freedom of an instrument at the aim.
void add_reach(SurgeonEye& best, const RayScene& scene, const OpeningGeometry& opening,
    const std::vector<SurfaceSample>& samples, const Job& job = {});

} // namespace retractor::planner
