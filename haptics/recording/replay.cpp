#include "haptics/recording/replay.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

namespace retractor::haptics {

namespace {
    constexpr double kOwnDamping = 5e-3; ///< N s/mm; assumed damping of a stylus in a hand
} // namespace

ReplayDevice::ReplayDevice(MotionRecording recording, std::size_t device)
    : recording_(std::move(recording))
    , device_(device)
{
    if (device_ >= recording_.devices.size())
        throw InputError("the recording has " + std::to_string(recording_.devices.size()) + " devices, none of number "
            + std::to_string(device_));
    if (recording_.tick_count() == 0)
        throw InputError("the recording is empty");
    const RecordedDevice& recorded = recording_.devices[device_];
    info_.name = recorded.name;
    info_.model = "replay of " + recorded.model;
    info_.serial = recorded.serial;
    info_.rate_hz = recording_.rate_hz;
    info_.limits.own_damping = kOwnDamping;
}

double ReplayDevice::duration_s() const noexcept { return recording_.times_s.back() - recording_.times_s.front(); }

MotionSample ReplayDevice::sample_at(double time_s) noexcept
{
    const std::vector<double>& times = recording_.times_s;
    RETRACTOR_ASSERT(cursor_ < times.size());
    double time = times.front() + time_s;
    // Recorded times are rounded: a tick that is due within a millionth of a step counts as reached.
    time += 1e-6 / recording_.rate_hz;
    if (time < times[cursor_])
        cursor_ = 0;
    while (cursor_ + 1 < times.size() && times[cursor_ + 1] <= time)
        ++cursor_;
    MotionSample sample = recording_.at(cursor_, device_);
    if (cursor_ + 1 == times.size())
        return sample;
    const double share = (time - times[cursor_]) / (times[cursor_ + 1] - times[cursor_]);
    if (!(share > 1e-3))
        return sample;
    const MotionSample& next = recording_.at(cursor_ + 1, device_);
    sample.position += share * (next.position - sample.position);
    sample.velocity += share * (next.velocity - sample.velocity);
    sample.orientation = sample.orientation.slerp(share, next.orientation);
    return sample;
}

DeviceReading ReplayDevice::read(double time_s, double /*step_s*/) noexcept
{
    const MotionSample sample = sample_at(time_s);
    return { .position = sample.position,
        .velocity = sample.velocity,
        .orientation = sample.orientation.toRotationMatrix(),
        .buttons = sample.buttons };
}

Vec3 ReplayDevice::write(const Vec3& force) noexcept
{
    return force.allFinite() ? clamped(force, info_.limits.max_force) : Vec3(Vec3::Zero());
}

} // namespace retractor::haptics
