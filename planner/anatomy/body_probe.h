#pragma once
// Finds the skin and the inner side of the wall along rays. A small smooth kernel is laid over the labels, so that
// every answer is a continuous function of the ray and shows no staircase of voxels. Units mm; frame patient LPS.

#include "mesh/image/volume.h"

#include <optional>

namespace retractor::planner {

/// Probes the labels, and keeps a reference to them. @pre the labels outlive the probe
class BodyProbe {
public:
    /// @throws InputError when no voxel has a wall label
    explicit BodyProbe(const mesh::LabelVolume& labels);

    /// Share of the labels in `mask` within a smooth ball round a point, from 0 to 1; a half on a flat boundary.
    double share(const mesh::LabelFlags& mask, const Vec3& point) const;

    /// Distance from `from` along the unit `direction` to the skin: the last passage from wall to outside. The distance
    /// is averaged over some voxels, so that a line drawn on the skin shows no staircase.
    std::optional<double> skin_along(const Vec3& from, const Vec3& direction) const;
    /// Distance to the first skin along the ray. Use this where an arm beside the chest has its own skin beyond a gap.
    std::optional<double> first_skin_along(const Vec3& from, const Vec3& direction) const;

    /// The place where a ray from outside the body first meets the skin, as a pointer on a picture does.
    /// @param direction unit
    std::optional<Vec3> skin_seen(const Vec3& from, const Vec3& direction) const;

    /// Thickness of the wall from a point on the skin along a unit direction into the body. The wall ends at the first
    /// cavity or organ that is at least kCavityMm deep.
    /// @returns nothing when there is no such cavity within `limit_mm`
    std::optional<double> wall_thickness(const Vec3& skin, const Vec3& direction, double limit_mm = 150.0) const;

    /// Outward unit normal of the body, averaged over about `radius_mm`.
    Vec3 skin_normal(const Vec3& skin, double radius_mm = 25.0) const;

    /// The point of the skin nearest to a point close to the skin. @throws InputError when none is found
    Vec3 project_to_skin(const Vec3& point) const;

    const mesh::LabelVolume& labels() const { return labels_; }
    static constexpr double kCavityMm = 4.0;

private:
    double share_within(const mesh::LabelFlags& mask, const Vec3& point, double radius) const;
    double averaged_skin_distance(const Vec3& from, const Vec3& direction, double distance) const;

    const mesh::LabelVolume& labels_;
    mesh::LabelFlags wall_;
    mesh::LabelFlags body_;
    Vec3 wall_centroid_ = Vec3::Zero();
    double radius_ = 0.0; ///< radius of the kernel, mm
    double reach_ = 0.0; ///< diagonal of the grid, mm
};

} // namespace retractor::planner
