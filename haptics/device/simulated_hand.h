#pragma once
// A simulated device with a person's hand on it. The mass of the stylus is coupled to the grip of the fingers, the grip
// to hand and arm, and the arm to the intended position. The program sees what a Touch would report: positions in steps
// of 0.055 mm, and forces limited to 3.3 N and one tick late. Ticks are deterministic. Units mm, s, N, tonne.
//
//   stylus (m) --grip (k1, b1)-- hand and arm (M) --arm (k2, b2)-- target
//
// Structure and numbers: Fu, Cavusoglu, Human arm-and-hand dynamics model with variability analyses for a stylus-based
// haptic interface, IEEE Trans. SMC-B 42(6), 2012; 15 people with the stylus of a Phantom Premium.

#include "haptics/device/device.h"
#include "haptics/device/hand_path.h"
#include "haptics/device/velocity_estimate.h"

#include <array>
#include <cstddef>

namespace retractor::haptics {

/// Parameters per axis of the device's frame: left-right, up-down, fore-aft.
struct HandParameters {
    Vec3 grip_stiffness; ///< k1, N/mm
    Vec3 grip_damping; ///< b1, N s/mm
    Vec3 mass; ///< M, tonne
    Vec3 arm_stiffness; ///< k2, N/mm
    Vec3 arm_damping; ///< b2, N s/mm
};
/// The nominal hand (Table II): a person who holds the stylus and does not resist.
HandParameters relaxed_grip();
/// The upper ends of the 95 % intervals over people and grips (Tables II and III): a hand that stiffens. (The authors
/// found little difference between 1 and 3 N of grip force, so the spread between people is used instead.)
HandParameters firm_grip();

struct SimulatedHandOptions {
    HandParameters hand = relaxed_grip();
    HandPath path = HandPath({ HandKey {} });
    double stylus_mass = 45e-6; ///< apparent mass of the Touch at its tip, tonne: 45 g by its data sheet
    /// N s/mm; our choice, small beside the grip's damping; the passivity bound may rely on this damping
    double stylus_damping = 5e-4;
    double friction = 0.0; ///< dry friction, N; the Touch has less than 0.26. Off, because dry friction hides vibration
    std::size_t delay_ticks = 1; ///< ticks between write() and the motors, at most 8
    int substeps = 20; ///< integration steps in one tick; a step is far below 2 sqrt(m/k1) = 13 ms
};

/// The stylus damping is reported in info().limits.own_damping.
class SimulatedHand : public Device {
public:
    /// @throws InputError naming the number that is out of range
    explicit SimulatedHand(const SimulatedHandOptions& options, const DeviceInfo& info = { .name = "simulated" });

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    /// Moves the hand to `time_s`.
    DeviceReading read(double time_s, double step_s) noexcept override;
    Vec3 write(const Vec3& force) noexcept override;

    /// Exact tip motion before the rounding of the encoders; for measurements.
    [[nodiscard]] const Vec3& true_position() const noexcept { return tip_; }
    [[nodiscard]] const Vec3& true_velocity() const noexcept { return tip_velocity_; }
    /// Force of the motors since the last read(), N.
    [[nodiscard]] const Vec3& motor_force() const noexcept { return motor_; }

private:
    void integrate(double from_s, double step_s) noexcept;

    static constexpr std::size_t kMaxDelay = 8;
    SimulatedHandOptions options_;
    DeviceInfo info_;
    Vec3 tip_, tip_velocity_ = Vec3::Zero();
    Vec3 hand_, hand_velocity_ = Vec3::Zero();
    Vec3 motor_ = Vec3::Zero();
    std::array<Vec3, kMaxDelay + 1> pending_; ///< forces that have not reached the motors yet, oldest first
    VelocityEstimate velocity_;
};

/// Rounds each axis to a multiple of `resolution`; a resolution of 0 changes nothing.
Vec3 quantised(const Vec3& position, double resolution) noexcept;

} // namespace retractor::haptics
