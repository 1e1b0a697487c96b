#pragma once
// Measures the share of the target that a surgeon sees through the opening. Rays run from a cone of eye positions to
// points on the target, and are tested against everything that can block them. Units mm, degrees; frame patient LPS.

#include "mesh/base/geometry.h"
#include "mesh/base/job.h"
#include "planner/measures/sight/ray_scene.h"
#include "planner/wall/field_geometry.h"

#include <string>
#include <vector>

namespace retractor::planner {

/// The eye positions of a cone, the central eye first. All eyes stand for equal areas of the cap.
/// @throws InputError on NaN, a zero axis, an up vector along the axis, or values out of range
std::vector<Vec3> eye_positions(const ViewCone& cone);

/// What one eye sees. Fractions are of the target's surface area, 0 to 1.
struct EyeView {
    Vec3 eye = Vec3::Zero();
    double visible_fraction = 0.0; ///< seen past all occluders
};

/// A share of the lines of sight (eye, sample) that reach the sample when the target stands alone.
struct SightShare {
    std::string name;
    double share = 0.0;
};

/// Shares of a total by name, the largest first; names with a count of zero are left out.
/// @param counts one per tissue
std::vector<SightShare> sorted_shares(
    const std::vector<RayScene::Tissue>& tissues, const std::vector<std::size_t>& counts, std::size_t total);

enum class ExposureStatus { done, cancelled };

struct [[nodiscard]] Exposure {
    ExposureStatus status = ExposureStatus::done;
    ViewCone cone; ///< cone that was used; report cone, samples and occluders with every number
    std::size_t samples = 0;
    double target_area_mm2 = 0.0;

    // Fractions are of the target's whole area. A closed target shows at most about half of its area to one eye. Read a
    // fraction beside its upper bound: the same measure with the wall removed (target and unretracted organs stay).
    double visible_fraction = 0.0; ///< seen from at least one eye of the cone
    double visible_fraction_unobstructed = 0.0; ///< upper bound of visible_fraction
    double mean_visible_fraction = 0.0; ///< mean over the eyes of the cone
    double central_eye_fraction = 0.0; ///< seen from the eye on the axis

    /// The first obstacles of the lines of sight, largest share first.
    std::vector<SightShare> blocked_by;
    /// The lines of sight with bone anywhere between eye and target, also behind other tissue. Only lines count that
    /// are clear when the wall is removed, so the shares show the cost of a rib. Largest share first; shares may
    /// overlap.
    std::vector<SightShare> bone_in_sight;

    std::vector<EyeView> eyes;
    std::vector<SurfaceSample> sample_points;
    std::vector<float> sample_seen; ///< share of the eyes that see each sample, 0 to 1
};

/// Measures what the eyes of a cone see of the target, which also hides parts of itself.
/// @param samples number of points on the target
/// @throws InputError on a bad cone, or when the central eye is inside a closed occluder or the target
Exposure measure_exposure(const RayScene& scene, const ViewCone& cone, int samples, const Job& job = {});

/// The same, with a scene of its own. @throws InputError also as RayScene does
Exposure measure_exposure(
    TriMesh target, std::vector<Occluder> occluders, const ViewCone& cone, int samples, const Job& job = {});

} // namespace retractor::planner
