#include "haptics/motion_recording.h"

#include "haptics/motion_formats.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"

#include <fstream>
#include <iterator>

namespace retractor {

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

void write_motion(const std::filesystem::path& path, const MotionRecording& recording)
{
    if (recording.devices.empty())
        throw InputError("a recording without devices is not written", path.string());
    if (recording.samples.size() != recording.tick_count() * recording.devices.size())
        throw InputError("the recording has " + std::to_string(recording.samples.size()) + " samples for "
                + std::to_string(recording.tick_count()) + " ticks of " + std::to_string(recording.devices.size())
                + " devices",
            path.string());
    write_file_atomically(path, path.extension() == ".csv" ? motion_to_csv(recording) : motion_to_binary(recording));
}

MotionRecording read_motion(const std::filesystem::path& path)
{
    std::ifstream in(path, std::ios::binary);
    if (!in)
        throw IoError("cannot be opened", path.string());
    const std::string content { std::istreambuf_iterator<char>(in), {} };
    if (in.bad())
        throw IoError("cannot be read", path.string());
    return is_binary_motion(content) ? motion_from_binary(content, path.string())
                                     : motion_from_csv(content, path.string());
}

} // namespace retractor
