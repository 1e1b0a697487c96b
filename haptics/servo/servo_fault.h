#pragma once
// Faults that stop a servo. A fault latches: the force falls to zero in a short ramp and stays zero until somebody arms
// the servo again. The reason can be read.

#include "haptics/device/device.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace retractor::haptics {

enum class FaultKind : std::uint8_t {
    none,
    let_go, ///< no fault: somebody ended the session
    bad_position, ///< a device's pose is not finite
    jump, ///< a device moved farther in one tick than a hand can
    late, ///< a tick started too late
    silent, ///< a device sent no new reading for too long
    over_limit, ///< a device reports warm motors, or too much force or velocity
    lost, ///< a device is gone
    bad_force, ///< the tissue's force is not finite
};

struct Fault {
    FaultKind kind = FaultKind::none;
    std::size_t device = 0; ///< index of the device; of the finger for bad_force
    std::uint64_t tick = 0;
    double time_s = 0.0;
    double value = 0.0; ///< mm of a jump; s of lateness or silence
};
/// A message such as "device 1 jumped by 140 mm in one tick (tick 2041, 2.041 s)"; empty without a fault.
std::string describe(const Fault& fault);

struct FaultOptions {
    double jump_mm = 100.0; ///< smallest displacement in one tick that is a fault, mm, device frame
    double late_s = 0.02; ///< longest time between two ticks: later, the held force no longer fits the moving hand
    double silence_s = 0.02; ///< longest time without a new reading from a device
    double ramp_down_s = 0.1; ///< time from full force to zero
    double ramp_up_s = 0.5; ///< time from zero to full force, at the start and after rearming
};

/// Keeps the first fault and ramps the force. Allocates nothing.
class FaultLatch {
public:
    explicit FaultLatch(const FaultOptions& options)
        : options_(options)
    {
    }
    /// Does nothing when a fault is latched already.
    void latch(const Fault& fault) noexcept;
    void rearm() noexcept { fault_ = {}; }
    /// The share of the force to write, 0 to 1. Call once per tick.
    double gain(double step_s) noexcept;
    [[nodiscard]] bool latched() const noexcept { return fault_.kind != FaultKind::none; }
    [[nodiscard]] const Fault& fault() const noexcept { return fault_; }
    [[nodiscard]] const FaultOptions& options() const noexcept { return options_; }

private:
    FaultOptions options_;
    Fault fault_;
    double gain_ = 0.0;
};

} // namespace retractor::haptics
