#include "haptics/recording/motion_file.h"

#include "haptics/recording/motion_formats.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"

#include <fstream>
#include <iterator>
#include <string>

namespace retractor::haptics {

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

} // namespace retractor::haptics
