#pragma once
// Limits of stiffness and damping that add no energy, and an observer and controller of energy. Units N, mm, s;
// energies in N mm (mJ).

#include "haptics/device/device.h"

#include <array>
#include <cstdint>

namespace retractor::haptics {

/// A spring and a damper between hand and proxy.
struct Coupling {
    double stiffness = 0.0; ///< N/mm
    double damping = 0.0; ///< N s/mm
};

/// The damping b of the device's mechanics that makes a wall with this coupling passive, N s/mm: b > K T/2 + |B|
/// (Colgate, Schenkel, Passivity of a class of sampled-data systems, 1997, eq. 22). Each tick of delay adds K T: the
/// same condition for a wall that responds d ticks late gives K T (2 d + 1)/2.
double damping_for_passivity(const Coupling& coupling, double step_s, int delay_ticks) noexcept;

/// Largest stiffness of a passive wall without damping of its own, N/mm.
double passive_stiffness(const DeviceLimits& limits, double step_s) noexcept;

/// Limits `wanted` to the device's largest stiffness and damping and, when the device's own damping is known, to the
/// passivity bound. Damping is reduced before stiffness.
/// @param gain device N/mm per scene N/mm; `wanted` and the result are in the scene
Coupling within_limits(const Coupling& wanted, const DeviceLimits& limits, double step_s, double gain = 1.0) noexcept;

struct PassivityOptions {
    /// Energy that may come out without a reaction, N mm: rounding, and the contact with a beating vessel.
    double allowance = 0.05;
    /// Power that the tissue may supply permanently, N mm/s (0.2 mW); larger for a pulse that the hand should feel.
    double active_power = 0.2;
};

/// Passivity observer and controller in impedance causality, one per device (Hannaford, Ryu, Time-domain passivity
/// control of haptic interfaces, IEEE Trans. Robotics and Automation 18(1), 2002). The observer counts the energy that
/// the simulated world releases through a force held from tick to tick, exactly for such a force (Ryu et al. 2004),
/// less the energy that the device's own damping and friction dissipate. The controller damps when more energy came out
/// than went in. Where damping cannot help (an oscillation faster than the delay of the loop), the controller reduces
/// the force, down to zero; in free space the force recovers. Allocates nothing.
class PassivityController {
public:
    PassivityController(const DeviceLimits& limits, const PassivityOptions& options);

    /// The force to write instead of `force`, device frame, N.
    /// @param position,velocity of the device at this tick
    /// @param touching false in free space, where the stored energy is reset
    Vec3 control(const Vec3& force, const Vec3& position, const Vec3& velocity, double step_s, bool touching) noexcept;
    /// Restarts the count, because ramped forces press tissue in without the full energy.
    /// @param stored energy stored in the tissue now, N mm
    void restart(double stored) noexcept { energy_ = stored; }
    /// Takes the force that the device applied after its own limits.
    void written(const Vec3& applied) noexcept;

    /// Energy that went in less energy that came out since the last free space, N mm.
    [[nodiscard]] double energy() const noexcept { return energy_; }
    [[nodiscard]] std::uint64_t damped_ticks() const noexcept { return damped_ticks_; }
    /// Factor on the force: 1 while damping is enough.
    [[nodiscard]] double share() const noexcept { return share_; }

private:
    static constexpr std::size_t kMaxDelay = 8;

    DeviceLimits limits_;
    PassivityOptions options_;
    std::size_t delay_;
    std::array<Vec3, kMaxDelay + 1> held_; ///< forces written, newest first
    Vec3 last_ = Vec3::Zero();
    bool started_ = false;
    double energy_ = 0.0, share_ = 1.0;
    std::uint64_t damped_ticks_ = 0;
};

} // namespace retractor::haptics
