#pragma once
// What straight instruments and a finger reach through an opening, past the target, the organs and the wall. Units mm;
// frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/base/job.h"
#include "planner/measures/sight/ray_scene.h"
#include "planner/wall/field_geometry.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace retractor::planner {

/// Diameter and length of an instrument's shaft, and the angle that two shafts need between them at their tips (ours).
inline constexpr double kShaftMm = 8.0, kShaftLengthMm = 300.0, kShaftsApartDeg = 15.0;
/// Thickness of an index finger, and how far it reaches below the skin while the hand stays outside (ours).
inline constexpr double kFingerMm = 16.0, kFingerReachMm = 80.0;

/// A unit vector across a line, which turns with the patient.
Vec3 across_of(const Vec3& line, const OpeningGeometry& opening);

/// The places that two shafts reach at once through the opening, in the same order. The search ends early where the
/// job is cancelled.
/// @param places indices of samples
std::vector<std::size_t> reached_by_two(const RayScene& scene, const OpeningGeometry& opening,
    const std::vector<SurfaceSample>& samples, const std::vector<std::size_t>& places, const Job& job = {});

/// What a straight finger touches: seen or not.
struct FingerReach {
    std::vector<std::size_t> touched {}; ///< indices of samples
    /// Where none is touched: how much longer the finger would have to be. Not set: a finger does not fit, however
    /// long, or touches.
    std::optional<double> lacks_mm {};
};
FingerReach finger_reach(const RayScene& scene, const OpeningGeometry& opening,
    const std::vector<SurfaceSample>& samples, const Job& job = {});

/// Area over which the near end of a shaft can move while its tip stays at a place: the surgical freedom, or area of
/// the limit points, on the sphere of kShaftLengthMm round the place. Only ways through the opening count.
double surgical_freedom_mm2(const RayScene& scene, const OpeningGeometry& opening, const Vec3& place);

} // namespace retractor::planner
