#include "haptics/device/device.h"

#include <cmath>

namespace retractor::haptics {

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

std::string problem_of(const SceneFrame& frame)
{
    const Mat3& A = frame.linear;
    if (!A.allFinite() || !frame.offset.allFinite())
        return "the device's frame in the scene is not finite";
    const double square = (A.transpose() * A).trace() / 3.0;
    if (!(square > 0.0) || !std::isfinite(square)
        || !((A.transpose() * A - square * Mat3::Identity()).cwiseAbs().maxCoeff() < kRotationTolerance * square))
        return "the device's frame in the scene is no rotation times a scale";
    return {};
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

} // namespace retractor::haptics
