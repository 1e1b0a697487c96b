#pragma once
// A device with a hand on it, in numbers: the stylus' mass hangs on the fingers' grip, the grip on the hand and arm,
// the arm on where the person means to be. What the program sees of it is what a Touch would tell: positions in steps
// of 0.055 mm, force limited to 3.3 N and one tick late. Ticks are deterministic.
//
//   stylus (m) --grip (k1, b1)-- hand and arm (M) --arm (k2, b2)-- target
//
// Structure and numbers: [Fu, Cavusoglu 2012, Human arm-and-hand dynamics model with variability analyses for a
// stylus-based haptic interface, IEEE Trans. SMC-B 42(6)], 15 people holding a Phantom Premium's stylus.

#include "haptics/device/device.h"
#include "haptics/device/hand_path.h"
#include "haptics/device/velocity_estimate.h"

#include <array>
#include <cstddef>

namespace retractor::haptics {

/// Per axis of the device's frame: left-right, up-down, fore-aft.
struct HandParameters {
    Vec3 grip_stiffness; ///< k1, N/mm
    Vec3 grip_damping; ///< b1, N s/mm
    Vec3 mass; ///< M, tonne
    Vec3 arm_stiffness; ///< k2, N/mm
    Vec3 arm_damping; ///< b2, N s/mm
};
/// The nominal hand (Table II): someone who holds the stylus and does not resist.
HandParameters relaxed_grip();
/// The upper ends of the intervals that hold 95 % of people and grips (Tables II and III): a hand that stiffens.
/// (Between 1 and 3 N of grip force the same authors found little difference, so the spread between people stands in
/// for it.)
HandParameters firm_grip();

struct SimulatedHandOptions {
    HandParameters hand = relaxed_grip();
    HandPath path = HandPath({ HandKey {} });
    double stylus_mass = 45e-6; ///< tonne: the Touch's apparent mass at its tip, 45 g by its data sheet
    double stylus_damping = 5e-4; ///< N s/mm: ours, small beside the grip's; what the passivity bound may rest on
    double friction = 0.0; ///< N, dry; the Touch's is below 0.26. Off, because dry friction hides vibration
    std::size_t delay_ticks = 1; ///< between write() and the motors, at most 8
    int substeps = 20; ///< of the integration in one tick: steps far below 2 sqrt(m/k1) = 13 ms
};

/// Its own damping is reported in info().limits.own_damping.
class SimulatedHand : public Device {
public:
    /// @throws InputError naming the number that is out of range
    explicit SimulatedHand(const SimulatedHandOptions& options, const DeviceInfo& info = { .name = "simulated" });

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    /// Moves the hand to `time_s`.
    DeviceReading read(double time_s, double step_s) noexcept override;
    Vec3 write(const Vec3& force) noexcept override;

    /// The truth that encoders round: for measuring.
    [[nodiscard]] const Vec3& true_position() const noexcept { return tip_; }
    [[nodiscard]] const Vec3& true_velocity() const noexcept { return tip_velocity_; }
    /// What the motors push with since the last read().
    [[nodiscard]] const Vec3& motor_force() const noexcept { return motor_; }

private:
    void integrate(double from_s, double step_s) noexcept;

    static constexpr std::size_t kMaxDelay = 8;
    SimulatedHandOptions options_;
    DeviceInfo info_;
    Vec3 tip_, tip_velocity_ = Vec3::Zero();
    Vec3 hand_, hand_velocity_ = Vec3::Zero();
    Vec3 motor_ = Vec3::Zero();
    std::array<Vec3, kMaxDelay + 1> pending_; ///< forces on their way to the motors, oldest first
    VelocityEstimate velocity_;
};

/// To whole multiples of `resolution`, each axis; 0 leaves it as it is.
Vec3 quantised(const Vec3& position, double resolution) noexcept;

} // namespace retractor::haptics
