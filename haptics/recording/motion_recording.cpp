#include "haptics/recording/motion_recording.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <utility>

namespace retractor::haptics {

MotionRecorder::MotionRecorder(std::vector<RecordedDevice> devices, double rate_hz, std::size_t max_ticks)
    : max_ticks_(max_ticks)
{
    if (devices.empty())
        throw InputError("a recording needs at least one device");
    if (max_ticks == 0)
        throw InputError("a recording needs room for at least one tick");
    recording_.rate_hz = rate_hz;
    recording_.devices = std::move(devices);
    recording_.times_s.reserve(max_ticks);
    recording_.samples.reserve(max_ticks * recording_.devices.size());
}

void MotionRecorder::add(double time_s, std::span<const MotionSample> samples) noexcept
{
    RETRACTOR_ASSERT(samples.size() == recording_.devices.size());
    if (recording_.times_s.size() == max_ticks_) {
        ++lost_;
        return;
    }
    recording_.times_s.push_back(time_s);
    recording_.samples.insert(recording_.samples.end(), samples.begin(), samples.end());
}

void place_pointers(MotionRecording& recording)
{
    for (RecordedDevice& device : recording.devices)
        if (device.model == "pointer" || device.model.ends_with("replay of pointer"))
            device.frame = SceneFrame {};
}

} // namespace retractor::haptics
