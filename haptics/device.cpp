#include "haptics/device.h"

namespace retractor {

Device::~Device() = default;
Ticked::~Ticked() = default;
TickSource::~TickSource() = default;

std::string_view to_string(DeviceTrouble trouble) noexcept
{
    switch (trouble) {
    case DeviceTrouble::none:
        return "none";
    case DeviceTrouble::silent:
        return "silent";
    case DeviceTrouble::over_limit:
        return "over its limits";
    case DeviceTrouble::lost:
        return "lost";
    }
    return "unknown";
}

void run_ticks(Ticked& ticked, std::uint64_t count, double step_s, std::uint64_t first)
{
    for (std::uint64_t i = first; i < first + count; ++i)
        ticked.tick(static_cast<double>(i) * step_s, step_s);
}

Vec3 clamped(const Vec3& force, double limit) noexcept
{
    const double length = force.norm();
    return length > limit ? Vec3(force * (limit / length)) : force;
}

} // namespace retractor
