#pragma once
// What instruments through ports see and reach in the closed chest: a rigid scope with its optics, and straight shafts.
// The wall is at rest; the lung of the operated side is held aside, as where it is deflated. Units mm, degrees; frame
// patient LPS.

#include "mesh/base/job.h"
#include "planner/case/patient.h"
#include "planner/measures/sight/ray_scene.h"

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace retractor::planner {

/// The optics of a rigid scope: the view leaves the shaft at an angle, to the side to which the surgeon turns it.
struct Optics {
    double tilt_deg = 30.0; ///< 0 to 60
    double field_deg = 70.0; ///< full angle of the view cone, above 0 to 120 (ours: usual scopes have 60 to 80)
};

/// Sizes of the instruments.
struct PortSizes {
    double scope_mm = 10.0, shaft_mm = 5.0; ///< diameters
    double longest_mm = 300.0; ///< working length of an instrument, from the skin
    double outside_mm = 200.0; ///< length of scope and shafts outside the skin, where hands and handles meet
};

/// A scope in place.
struct ScopeView {
    Vec3 tip = Vec3::Zero(); ///< the lens
    Vec3 view = Vec3::UnitZ(); ///< axis of the view cone, unit
    double insertion_mm = 0.0; ///< from the skin to the tip
    double to_target_mm = 0.0; ///< from the tip to the middle of the target
    std::size_t seen = 0; ///< samples, at less than kLargestIncidenceDeg
    std::vector<bool> sees {}; ///< per sample
    std::size_t bound = 0; ///< samples that the tip would see without organs and wall, at the same incidence
};

/// The closed chest for rays. Safe to use from several threads.
class PortScene {
public:
    /// @param left the operated side: its lung is held aside, with the fat of the mediastinum and the pericardium
    /// @param aside other organs that are held aside
    /// @throws InputError as Patient::target() and organs_aside() do
    PortScene(Patient& patient, const TargetSpec& target, bool left, const std::vector<std::string>& aside, int samples,
        const Job& job);
    /// The same of surfaces. @param view_blockers organs and the inner side of the wall, which end a view
    /// @param shaft_blockers organs and bones, through which no shaft goes
    PortScene(const TriMesh& target, std::vector<Occluder> view_blockers, std::vector<Occluder> shaft_blockers,
        int samples, const Job& job);

    const std::vector<SurfaceSample>& samples() const { return samples_; }
    const Vec3& middle() const { return middle_; } ///< of the target's surface

    /// The best place of a scope through a port.
    /// @param skin of the port; @param wall_mm thickness of the wall there: the tip lies inside it
    ScopeView best_scope(const Vec3& skin, double wall_mm, const Optics& optics, const PortSizes& sizes) const;
    /// For each sample whether a shaft through a port comes to it.
    std::vector<bool> reached(const Vec3& skin, const PortSizes& sizes) const;

private:
    ScopeView look(const Vec3& skin, const Vec3& tip, const Optics& optics) const;
    bool shaft_fits(const Vec3& tip, const Vec3& skin, double diameter_mm, double taper_mm) const;

    std::unique_ptr<RayScene> view_, shafts_;
    std::vector<SurfaceSample> samples_;
    Vec3 middle_ = Vec3::Zero();
};

/// Smallest distance of two straight pieces.
double distance_of_pieces(const std::pair<Vec3, Vec3>& one, const std::pair<Vec3, Vec3>& other);

/// @throws InputError on sizes and angles out of range
void check_optics(const Optics& optics);

} // namespace retractor::planner
