#include "haptics/servo/servo_fault.h"

#include "mesh/base/text_format.h"

#include <algorithm>

namespace retractor::haptics {

namespace {

    std::string what_happened(const Fault& fault)
    {
        const std::string device = "device " + std::to_string(fault.device);
        switch (fault.kind) {
        case FaultKind::none:
            break;
        case FaultKind::let_go:
            return "the servo was told to let go";
        case FaultKind::bad_position:
            return device + " gave a pose that is not finite";
        case FaultKind::jump:
            return device + " jumped by " + formatted("%.0f mm in one tick", fault.value);
        case FaultKind::late:
            return "a tick came " + formatted("%.4g s", fault.value) + " after the one before";
        case FaultKind::silent:
            return device + " has been silent for " + formatted("%.3g s", fault.value);
        case FaultKind::over_limit:
            return device + " is over its limits (warm motors, force or velocity)";
        case FaultKind::lost:
            return device + " is lost";
        case FaultKind::bad_force:
            return "the tissue's force on finger " + std::to_string(fault.device) + " is not finite";
        }
        return {};
    }

} // namespace

std::string describe(const Fault& fault)
{
    if (fault.kind == FaultKind::none)
        return {};
    return what_happened(fault)
        + formatted(" (tick %llu, %.3f s)", static_cast<unsigned long long>(fault.tick), fault.time_s);
}

void FaultLatch::latch(const Fault& fault) noexcept
{
    if (!latched())
        fault_ = fault;
}

double FaultLatch::gain(double step_s) noexcept
{
    gain_ += latched() ? -step_s / options_.ramp_down_s : step_s / options_.ramp_up_s;
    gain_ = std::clamp(gain_, 0.0, 1.0);
    return gain_;
}

} // namespace retractor::haptics
