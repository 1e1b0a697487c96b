#pragma once
// A target and everything that can block the view of it, for rays. Units mm; frame patient LPS.
//
// Rays are traced in single precision (Embree), in coordinates relative to the centre of the scene. Under rigid motion
// the numbers agree to about 1e-3, because a sample at an edge of the opening may fall to the other side.

#include "mesh/base/geometry.h"
#include "mesh/base/job.h"
#include "mesh/image/volume.h"
#include "planner/measures/sight/aperture.h"

#include <Eigen/Geometry>

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::planner {

/// Something that blocks the view. Organs that are held aside are left out.
struct Occluder {
    std::string name; ///< name of triangles whose label is not in `labels`
    TriMesh surface;
    mesh::LabelTable labels; ///< names and materials of the surface's triangle labels; may be empty
    std::string material; ///< material of triangles whose label is not in `labels`; may be empty
    /// True for what the approach moves, which the upper bound removes: the wall that is opened, the blades in it, and
    /// lungs that are held aside. False for organs that stay in the way. Bone inside the wall (tissue_surface() of the
    /// ribs) is a wall occluder of its own. The wall round the bone blocks the same rays, so the bone only gives the
    /// rib in the line of sight its name.
    bool wall = true;
};

/// A point on the target. All samples of a target stand for equal areas.
struct SurfaceSample {
    Vec3 position;
    int triangle = 0;
};

/// Samples a surface at points: deterministic, weighted by area and stratified. Equal steps along the cumulated area
/// pick the triangle, and the R2 low-discrepancy sequence (M. Roberts 2018) picks the place in the triangle. The
/// samples move with the surface under rigid motion.
/// @throws InputError on a count below one; @pre the surface has an area
std::vector<SurfaceSample> surface_samples(const TriMesh& surface, int count);

/// What a ray can meet; combined with |.
enum RayMask : unsigned { kTargetMask = 1, kOrganMask = 2, kWallMask = 4 };

/// The target does not hide a sample from a ray that comes this near to the sample, mm. The distance is larger than the
/// error of single precision (about 1e-4 mm at 1 m), and smaller than a surgeon could see.
inline constexpr double kSampleToleranceMm = 0.02;
/// No other surface hides a sample from this near either, mm. Surfaces of touching labels are smoothed separately and
/// overlap by a part of a voxel, so an artery on the heart would dip under the surface of the heart.
inline constexpr double kTouchingMm = 0.5;

struct RayHit {
    double distance_mm = 0.0;
    std::size_t tissue = 0; ///< index into RayScene::tissues
};

/// Target and occluders in Embree.
struct RayScene {
    /// Name and material of triangles.
    struct Tissue {
        std::string name, material;
    };

    /// Builds the scene. The ledger records the part "ray tracer".
    /// @throws InputError on an empty or malformed target, or a malformed occluder (named). An occluder without
    /// triangles is allowed.
    RayScene(TriMesh target, std::vector<Occluder> occluders, const Job& job);
    /// The same scene behind a wall that only an aperture passes. It shares the surfaces, so it takes no time to make.
    /// The wall is the tissue of this name. @throws InputError where the scene has no such tissue
    RayScene(const RayScene& open, Aperture aperture, std::string_view wall);
    ~RayScene();
    RayScene(const RayScene&) = delete;
    RayScene& operator=(const RayScene&) = delete;

    const TriMesh& target() const;
    const std::vector<Tissue>& tissues() const;
    double target_area_mm2() const;
    /// Unit normal of the target's triangle with a sample.
    Vec3 normal(const SurfaceSample& sample) const;

    /// Whether nothing lies on a ray between two distances. @param direction unit
    bool clear(const Vec3& from, const Vec3& direction, double near_mm, double far_mm, unsigned mask) const;
    /// The first thing on a ray between two distances. @param direction unit
    std::optional<RayHit> first(
        const Vec3& from, const Vec3& direction, double near_mm, double far_mm, unsigned mask) const;
    /// All tissues along a ray, each once.
    std::vector<std::size_t> tissues_along(const Vec3& from, const Vec3& direction, double far_mm, unsigned mask) const;
    /// The name of the closed body that contains a point; empty: none does.
    std::string enclosing(const Vec3& point) const;

private:
    struct Parts;
    struct Wall {
        Aperture aperture;
        std::size_t tissue = 0;
    };
    std::shared_ptr<const Parts> parts_;
    std::optional<Wall> wall_;
};

} // namespace retractor::planner
