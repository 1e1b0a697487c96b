#pragma once
// The interface between the servo and any tissue model: condensed finite elements, springs or spheres. Frame: the
// scene's (patient LPS when a case is loaded). Units mm, s, N.

#include "mesh/base/geometry.h"

#include <cstddef>
#include <span>
#include <string_view>

namespace retractor::haptics {

/// One fingertip: a rigid sphere at the end of a device.
struct Fingertip {
    Vec3 position = Vec3::Zero(); ///< centre, mm
    Vec3 velocity = Vec3::Zero(); ///< mm/s
    double radius = 4.0; ///< mm
    bool placed = false; ///< placed at this position without a motion from the position of the last tick
};

/// The response of the tissue to one fingertip.
struct FingerContact {
    Vec3 force = Vec3::Zero(); ///< on the finger, N; pushes only (contact is unilateral)
    /// Centre of the fingertip as the tissue holds it (god-object), mm; the fingertip's position when free.
    Vec3 proxy = Vec3::Zero();
    Vec3 normal = Vec3::Zero(); ///< outward unit normal at the contact; zero when free
    double depth = 0.0; ///< depth of the fingertip under the surface along the normal, mm
    /// Stiffness of the tissue at the contact along the normal, N/mm, which bounds the coupling; 0 when free.
    double stiffness = 0.0;
    bool touching = false;
    /// Of a finger in an opening (haptics/surroundings/hindered_tissue.h):
    bool stopped = false; ///< the surroundings keep the finger from where the hand is
    Vec3 stopped_at = Vec3::Zero(); ///< centre of the fingertip where it fits, mm
    Vec3 held_back = Vec3::Zero(); ///< the part of `force` by which the surroundings hold the hand back, N
    int stopped_by = -1; ///< what stops it (FingerAccess::Answer::hindrance); -1: nothing, or not known
    Vec3 outward = Vec3::Zero(); ///< from the tip to the hand, unit; zero: not known
};

/// A tissue under fingertips. tick() belongs to the servo thread, all other functions to the simulation thread; both
/// threads may run at once.
class TissueResponse {
public:
    virtual ~TissueResponse();

    [[nodiscard]] virtual std::string_view name() const noexcept = 0;
    /// Number of fingertips that tick() takes.
    [[nodiscard]] virtual std::size_t finger_count() const noexcept = 0;

    /// Servo thread, about every millisecond: computes the contacts at `time_s` since the start, `step_s` after the
    /// last tick. Allocates nothing, takes no lock, throws nothing. When the tissue has no answer, the force is NaN,
    /// and the servo latches a fault.
    /// @pre both spans have finger_count() entries; positions are finite
    virtual void tick(double time_s, double step_s, std::span<const Fingertip> fingers,
        std::span<FingerContact> contacts) noexcept = 0;

    /// The touchable surface at rest.
    [[nodiscard]] virtual const TriMesh& surface() const noexcept = 0;
    /// Simulation thread: brings background work (edits, columns fetched ahead of a finger, spheres that settle) up to
    /// the newest tick. Writes the deformed surface into `deformed`, one row per vertex of surface(), mm.
    virtual void follow(Points& deformed) = 0;
};

} // namespace retractor::haptics
