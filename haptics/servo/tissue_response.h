#pragma once
// What the servo asks of tissue, whatever computes it: condensed finite elements, springs or spheres.
// Frame: the scene's (patient LPS when a case is loaded). Units mm, s, N.

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
    bool placed = false; ///< put here, whatever lies between: it did not move here from where the last tick had it
};

/// What the tissue answers one fingertip.
struct FingerContact {
    Vec3 force = Vec3::Zero(); ///< on the finger, N; only ever pushes (contact is unilateral)
    Vec3 proxy
        = Vec3::Zero(); ///< the fingertip's centre as the tissue holds it (god-object), mm; its position when free
    Vec3 normal = Vec3::Zero(); ///< outward unit normal where it is held; zero when free
    double depth = 0.0; ///< how far the fingertip presses the tissue in along the normal, mm
    double stiffness
        = 0.0; ///< of the tissue at this place along the normal, N/mm: what bounds the coupling; 0 when free
    bool touching = false;
};

/// A tissue under fingertips. tick() belongs to the servo thread, everything else to the simulation thread; the two may
/// run at once.
class TissueResponse {
public:
    virtual ~TissueResponse();

    [[nodiscard]] virtual std::string_view name() const noexcept = 0;
    /// How many fingertips tick() takes.
    [[nodiscard]] virtual std::size_t finger_count() const noexcept = 0;

    /// Servo thread, about every millisecond: the contacts at `time_s` since the start, `step_s` after the tick before.
    /// Allocates nothing, takes no lock, throws nothing. An answer it cannot give is a force of NaN: the servo latches
    /// a ramp to zero.
    /// @pre both spans have finger_count() entries; positions are finite
    virtual void tick(double time_s, double step_s, std::span<const Fingertip> fingers,
        std::span<FingerContact> contacts) noexcept = 0;

    /// The surface that is touched, at rest.
    [[nodiscard]] virtual const TriMesh& surface() const noexcept = 0;
    /// Simulation thread: brings background work forward (edits, columns fetched ahead of a finger, spheres settling)
    /// to the newest tick, and writes the deformed surface (as many rows as surface().vertices) into `deformed`.
    virtual void follow(Points& deformed) = 0;
};

} // namespace retractor::haptics
