#include "haptics/pointer_device.h"

#include "mesh/base/error.h"

#include <cmath>

namespace retractor {

PointerDevice::PointerDevice(const PointerOptions& options, const DeviceInfo& info)
    : time_s_(options.time_s)
    , info_(info)
{
    if (!(options.time_s > 0.0))
        throw InputError("the time constant must be positive", "time_s");
    if (!((options.workspace.high - options.workspace.low).minCoeff() > 0.0))
        throw InputError("the workspace is empty", "workspace");
    if (info_.model.empty())
        info_.model = "pointer";
    info_.workspace = options.workspace;
    position_ = pointed_.position = 0.5 * (options.workspace.low + options.workspace.high);
    publish();
}

void PointerDevice::publish()
{
    pointed_.position = pointed_.position.cwiseMax(info_.workspace.low).cwiseMin(info_.workspace.high);
    target_.draft() = pointed_;
    target_.publish();
}

void PointerDevice::go_to(const Vec3& place, bool hops)
{
    if (!place.allFinite())
        return;
    pointed_.position = place;
    pointed_.hops = hops;
    publish();
}

void PointerDevice::point_at(double x, double y) { go_to({ x, y, pointed_.position.z() }, false); }
void PointerDevice::point_at(const Vec3& place) { go_to(place, false); }
void PointerDevice::hop_to(const Vec3& place) { go_to(place, true); }

void PointerDevice::turn_wheel(double mm)
{
    go_to(pointed_.position - Vec3(0.0, 0.0, mm), false); // z is towards the user
}

void PointerDevice::press(std::uint32_t buttons)
{
    pointed_.buttons = buttons;
    publish();
}

DeviceReading PointerDevice::read(double, double step_s) noexcept
{
    const Target& target = target_.latest();
    const Vec3 way = target.position - position_;
    const Vec3 step = target.hops ? clamped(way, kHop) : Vec3((1.0 - std::exp(-step_s / time_s_)) * way);
    position_ += step;
    return { .position = position_,
        .velocity = step_s > 0.0 && !target.hops ? Vec3(step / step_s) : Vec3(Vec3::Zero()),
        .buttons = target.buttons };
}

Vec3 PointerDevice::write(const Vec3&) noexcept { return Vec3::Zero(); }

} // namespace retractor
