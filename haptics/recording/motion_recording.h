#pragma once
// Recorded motion of devices, tick by tick: time, pose, velocity, buttons, commanded and applied force of each device.
// After a jump the recording also contains the poses that the tissue did not see. In place of an impossible pose the
// last pose is recorded, at rest. motion_file.h reads and writes files. Units mm, s, N. Frame: each device's own, with
// its place in the scene.

#include "haptics/device/device.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::haptics {

/// The sample of one device at one tick.
struct MotionSample {
    Vec3 position = Vec3::Zero();
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity(); ///< rotation of the stylus axes
    Vec3 velocity = Vec3::Zero();
    Vec3 commanded_force = Vec3::Zero(); ///< wanted force before limits
    Vec3 applied_force = Vec3::Zero(); ///< force on the hand after every limit
    std::uint32_t buttons = 0;
};

struct RecordedDevice {
    std::string name {}, model {}, serial {};
    /// Frame at the first tick; absent in version 1 of the formats, except for pointers.
    std::optional<SceneFrame> frame {};
};

struct MotionRecording {
    double rate_hz = 1000.0; ///< nominal tick rate
    std::vector<RecordedDevice> devices;
    std::vector<double> times_s; ///< time of each tick, increasing
    std::vector<MotionSample> samples; ///< ordered by tick, then by device

    [[nodiscard]] std::size_t tick_count() const noexcept { return times_s.size(); }
    [[nodiscard]] const MotionSample& at(std::size_t tick, std::size_t device) const noexcept
    {
        return samples[tick * devices.size() + device];
    }
};

/// Gives the scene's own frame to every pointer, and to every replay of a pointer. Version 1 of the formats has no
/// frames, but pointers always moved in the scene's frame.
void place_pointers(MotionRecording& recording);

/// Fills a recording inside the tick. The constructor reserves room for all ticks.
class MotionRecorder {
public:
    /// @throws InputError when there is no device or no room
    MotionRecorder(std::vector<RecordedDevice> devices, double rate_hz, std::size_t max_ticks);

    /// Servo thread: true before the first add(), when lies_at() must be called.
    [[nodiscard]] bool empty() const noexcept { return recording_.times_s.empty(); }
    /// Sets the frame of a device at the first tick. Allocates nothing.
    void lies_at(std::size_t device, const SceneFrame& frame) noexcept { recording_.devices[device].frame = frame; }
    /// Adds a tick. Allocates nothing; a tick beyond the room is counted but not kept.
    /// @pre there is one sample per device; times increase
    void add(double time_s, std::span<const MotionSample> samples) noexcept;
    [[nodiscard]] std::size_t lost_ticks() const noexcept { return lost_; }
    /// @pre no tick runs any more
    [[nodiscard]] const MotionRecording& recording() const noexcept { return recording_; }

private:
    MotionRecording recording_;
    std::size_t max_ticks_, lost_ = 0;
};

} // namespace retractor::haptics
