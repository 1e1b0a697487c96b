#pragma once
// What may be rendered without adding energy, and a watch that nothing more is.
// Units N, mm, s: energies in N mm (mJ).

#include "haptics/device/device.h"

#include <array>
#include <cstdint>

namespace retractor::haptics {

/// A spring and a damper between hand and proxy.
struct Coupling {
    double stiffness = 0.0; ///< N/mm
    double damping = 0.0; ///< N s/mm
};

/// The damping b that a device's mechanics must have for a wall of this coupling to be passive: b > K T/2 + |B|
/// [Colgate, Schenkel 1997, Passivity of a class of sampled-data systems, eq. 22], and K T more for each tick of delay
/// (the same condition for a wall that answers d ticks late: K T (2 d + 1)/2).
double damping_for_passivity(const Coupling& coupling, double step_s, int delay_ticks) noexcept;

/// The stiffest passive wall without damping of its own.
double passive_stiffness(const DeviceLimits& limits, double step_s) noexcept;

/// `wanted` within what the device can do: its largest stiffness and damping, and, when its own damping is known, the
/// passivity bound; damping is given up before stiffness.
/// @param gain device N/mm per scene N/mm; `wanted` and the result are the scene's
Coupling within_limits(const Coupling& wanted, const DeviceLimits& limits, double step_s, double gain = 1.0) noexcept;

struct PassivityOptions {
    double allowance
        = 0.05; ///< N mm that may come out before anything is done: rounding, and the touch of a beating vessel
    double active_power
        = 0.2; ///< N mm/s (0.2 mW) that the tissue may give for good; more for a pulse that is to be felt
};

/// Passivity observer and controller [Hannaford, Ryu 2002, Time-domain passivity control of haptic interfaces, IEEE
/// Trans. Robotics and Automation 18(1)], impedance causality, one per device: counts the energy that comes out of the
/// simulated world through a force held from tick to tick (that force exactly: [Ryu et al. 2004]), credits what the
/// device's own damping and friction take, and damps when more came out than went in. Where damping cannot help - a
/// buzz faster than the loop's delay - the wall gets softer instead, until it gives nothing any more; in free space it
/// hardens again. Allocates nothing.
class PassivityController {
public:
    PassivityController(const DeviceLimits& limits, const PassivityOptions& options);

    /// The force to write instead of `force`.
    /// @param position,velocity of the device at this tick
    /// @param touching nothing is stored in free space: what went in before cannot pay for what comes later
    Vec3 control(const Vec3& force, const Vec3& position, const Vec3& velocity, double step_s, bool touching) noexcept;
    /// Counts anew: while forces are ramped, tissue is pressed in without paying. @param stored what lies in it now, N
    /// mm
    void restart(double stored) noexcept { energy_ = stored; }
    /// What the device made of it.
    void written(const Vec3& applied) noexcept;

    /// Energy that went in, less what came out, since the last time nothing was touched, N mm.
    [[nodiscard]] double energy() const noexcept { return energy_; }
    [[nodiscard]] std::uint64_t damped_ticks() const noexcept { return damped_ticks_; }
    /// Share of the force that is left: 1 as long as damping was enough.
    [[nodiscard]] double share() const noexcept { return share_; }

private:
    static constexpr std::size_t kMaxDelay = 8;

    DeviceLimits limits_;
    PassivityOptions options_;
    std::size_t delay_;
    std::array<Vec3, kMaxDelay + 1> held_; ///< forces written, the newest first
    Vec3 last_ = Vec3::Zero();
    bool started_ = false;
    double energy_ = 0.0, share_ = 1.0;
    std::uint64_t damped_ticks_ = 0;
};

} // namespace retractor::haptics
