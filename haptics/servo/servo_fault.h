#pragma once
// What makes a servo let go: a fault latches, the force goes to zero in a short ramp and stays there until somebody
// arms it again, and the reason can be read.

#include "haptics/device/device.h"

#include <cstddef>
#include <cstdint>
#include <string>

namespace retractor::haptics {

enum class FaultKind : std::uint8_t {
    none,
    let_go, ///< no fault: somebody ended the session
    bad_position, ///< a device's pose is not finite
    jump, ///< a device moved further in one tick than a hand can
    late, ///< a tick came too late
    silent, ///< a device has told nothing new for too long
    over_limit, ///< a device complains: warm motors, force, velocity
    lost, ///< a device is gone
    bad_force, ///< the tissue's answer is not finite
};

struct Fault {
    FaultKind kind = FaultKind::none;
    std::size_t device = 0; ///< or finger, for bad_force
    std::uint64_t tick = 0;
    double time_s = 0.0;
    double value = 0.0; ///< mm of a jump, s of lateness or silence
};
/// "device 1 jumped by 140 mm in one tick (tick 2041, 2.041 s)"; empty without a fault.
std::string describe(const Fault& fault);

struct FaultOptions {
    double jump_mm = 100.0; ///< in one tick, device frame; as far is too far
    double late_s = 0.02; ///< since the tick before: held force and moving hand are out of step by then
    double silence_s = 0.02; ///< without news from a device
    double ramp_down_s = 0.1; ///< from full force to none
    double ramp_up_s = 0.5; ///< after start and rearming
};

/// Allocates nothing.
class FaultLatch {
public:
    explicit FaultLatch(const FaultOptions& options)
        : options_(options)
    {
    }
    /// The first fault is kept.
    void latch(const Fault& fault) noexcept;
    void rearm() noexcept { fault_ = {}; }
    /// Once per tick: the share of the force that may go out.
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
