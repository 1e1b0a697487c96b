#pragma once
// How much of the target a surgeon sees through the opening: rays from a cone of eye positions to points
// on the target, against everything that can block them. Units mm, degrees; frame patient LPS.
//
// Rays are traced in single precision (Embree), in coordinates relative to the centre of the scene: the numbers
// agree under rigid motion to about 1e-3 (a sample at an edge of the opening may fall to the other side).

#include "mesh/base/geometry.h"
#include "mesh/base/job.h"
#include "mesh/image/volume.h"
#include "planner/wall/field_geometry.h"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// Something that blocks the view. Leave out retracted organs.
struct Occluder {
    std::string name; ///< of triangles whose label is not in `labels`
    TriMesh surface;
    mesh::LabelTable labels; ///< names and materials of the surface's triangle labels; may be empty
    std::string material; ///< of triangles whose label is not in `labels`; may be empty
    /// True for the wall that is opened (removed for the upper bound), false for organs that stay in the way.
    /// Bone inside the wall (tissue_surface() of the ribs) is a wall occluder of its own: it blocks nothing that the
    /// wall round it does not block already, and it is what names a rib in the line of sight.
    bool wall = true;
};

/// The eye positions of a cone, the central one first; each stands for the same area of the cap.
/// @throws InputError on NaN, a zero axis, up along the axis, or values out of range.
std::vector<Vec3> eye_positions(const ViewCone& cone);

/// A point on a surface; each stands for the same area.
struct SurfaceSample {
    Vec3 position;
    int triangle = 0;
};

/// Deterministic, area-weighted and stratified: equal steps along the cumulated area pick the triangle, the R2
/// low-discrepancy sequence (M. Roberts 2018) the place in it. Moves with the surface under rigid motion.
/// @throws InputError on an empty surface, NaN, zero area or count < 1.
std::vector<SurfaceSample> surface_samples(const TriMesh& surface, int count);

struct ExposureOptions {
    int samples = 2000; ///< on the target
    /// The target does not hide a sample from a ray that comes this near to it. Larger than what single precision
    /// leaves (about 1e-4 mm at 1 m), smaller than anything a surgeon could see.
    double tolerance_mm = 0.02;
    /// Nor does anything else hide it from this near: surfaces of touching labels are smoothed apart from each other
    /// and overlap by a part of a voxel, so that an artery on the heart would dip under the heart's surface.
    double contact_mm = 0.5;
    std::vector<std::string> bone_materials { "bone", "cartilage" };
};

/// One eye. All fractions are of the target's surface area, 0 to 1.
struct EyeView {
    Vec3 eye = Vec3::Zero();
    double visible_fraction = 0.0; ///< seen past everything
    double unobstructed_fraction = 0.0; ///< seen with the wall removed
    /// Seen part over what is seen with the wall removed, by solid angle: the share of target pixels in this
    /// eye's picture; 0 when nothing is seen with the wall removed.
    double picture_share = 0.0;
    std::string inside; ///< name of the closed occluder the eye is inside of; empty when it is outside all
};

/// A share of the lines of sight (eye, sample) that reach the sample when the target stands alone.
struct SightShare {
    std::string name;
    double share = 0.0;
};

enum class ExposureStatus { done, cancelled };

struct [[nodiscard]] Exposure {
    ExposureStatus status = ExposureStatus::done;
    ViewCone cone; ///< as used; state cone, samples and occluders with every number
    std::size_t samples = 0;
    double target_area_mm2 = 0.0;

    // Fractions of the target's whole area. A closed target shows at most about half of it to one eye, so read each
    // beside its upper bound, the same measure with the wall removed (target and unretracted organs stay).
    double visible_fraction = 0.0; ///< seen from at least one eye of the cone
    double visible_fraction_unobstructed = 0.0; ///< its upper bound
    double mean_visible_fraction = 0.0; ///< mean over the cone of what one eye sees
    double mean_unobstructed_fraction = 0.0;
    double best_eye_fraction = 0.0; ///< what the best-placed eye sees
    int best_eye = 0; ///< index into `eyes`
    double central_eye_fraction = 0.0; ///< what the eye on the axis sees
    /// visible_fraction over its upper bound: 1 when the wall hides nothing; 0 when there is nothing to see.
    double relative_visible_fraction = 0.0;

    /// What lines of sight meet first, largest share first; with reached_share they add up to 1.
    std::vector<SightShare> blocked_by;
    double reached_share = 0.0;
    /// Bone anywhere between eye and target on lines of sight that are clear with the wall removed, also behind
    /// other tissue: what a rib costs. Largest share first; shares may overlap.
    std::vector<SightShare> bone_in_sight;

    std::vector<EyeView> eyes;
    std::vector<SurfaceSample> sample_points;
    std::vector<float> sample_seen; ///< per sample: the share of eyes that see it, 0 to 1
};

/// The first thing a ray meets.
struct RayHit {
    double distance_mm = 0.0;
    std::string name;
    std::string material;
    bool target = false;
    int triangle = 0; ///< of the target's or the occluder's surface
};

/// Target and occluders, ready to be looked at; built once, queried from any number of cones.
class RayScene {
public:
    /// The target blocks the view of itself. Records the part "ray tracer".
    /// @throws InputError on an empty or malformed target, or a malformed occluder (named); an occluder without
    /// triangles is allowed.
    RayScene(TriMesh target, std::vector<Occluder> occluders, const Job& job = {});
    ~RayScene();
    RayScene(RayScene&&) noexcept;
    RayScene& operator=(RayScene&&) noexcept;

    /// @throws InputError on a bad cone or bad options, or when the central eye is inside a closed occluder or the
    /// target (other eyes inside one are reported in their EyeView and see what rays from there see).
    Exposure exposure(const ViewCone& cone, const ExposureOptions& options = {}, const Job& job = {}) const;

    /// The first surface between two points. @throws InputError on NaN or coinciding points.
    std::optional<RayHit> first_hit(const Vec3& from, const Vec3& to) const;

    /// The name of a closed surface that encloses the point; empty when there is none.
    std::string enclosing(const Vec3& point) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// RayScene built and asked once.
Exposure measure_exposure(const TriMesh& target, const std::vector<Occluder>& occluders, const ViewCone& cone,
    const ExposureOptions& options = {}, const Job& job = {});

} // namespace retractor::planner
