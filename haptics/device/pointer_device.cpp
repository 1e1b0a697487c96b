#include "haptics/device/pointer_device.h"

#include "mesh/base/error.h"

#include <cmath>

namespace retractor::haptics {

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
    for (Vec3* place : { &pointed_.position, &pointed_.landing })
        *place = place->cwiseMax(info_.workspace.low).cwiseMin(info_.workspace.high);
    target_.draft() = pointed_;
    target_.publish();
}

void PointerDevice::point_at(const Vec3& place)
{
    if (!place.allFinite())
        return;
    pointed_.position = place;
    publish();
}

void PointerDevice::hop_to(const Vec3& place)
{
    if (!place.allFinite())
        return;
    pointed_.landing = place;
    ++pointed_.hops;
    point_at(place);
}

DeviceReading PointerDevice::read(double, double step_s) noexcept
{
    const Target& target = target_.latest();
    if (hops_done_ != target.hops) {
        const Vec3 way = target.landing - position_;
        if (way.norm() <= kHop) {
            position_ = target.landing;
            hops_done_ = target.hops;
        } else
            position_ += clamped(way, kHop);
        return { .position = position_, .velocity = Vec3::Zero() };
    }
    const Vec3 step = (1.0 - std::exp(-step_s / time_s_)) * (target.position - position_);
    position_ += step;
    return { .position = position_, .velocity = step_s > 0.0 ? Vec3(step / step_s) : Vec3(Vec3::Zero()) };
}

Vec3 PointerDevice::write(const Vec3&) noexcept { return Vec3::Zero(); }

} // namespace retractor::haptics
