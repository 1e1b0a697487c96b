#pragma once
// What devices did and were told, tick by tick: time, pose, velocity, buttons, commanded and applied force per device.
// Also what the tissue did not see, after a jump; where a device told what cannot be, its last pose stands, at rest.
// Files of recordings: motion_file.h. Units mm, s, N; each device's own frame, and how that lay in the scene.

#include "haptics/device/device.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace retractor::haptics {

/// One device at one tick.
struct MotionSample {
    Vec3 position = Vec3::Zero();
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity(); ///< of the stylus' axes
    Vec3 velocity = Vec3::Zero();
    Vec3 commanded_force = Vec3::Zero(); ///< what the tissue asked for
    Vec3 applied_force = Vec3::Zero(); ///< after every limit, on the hand
    std::uint32_t buttons = 0;
};

struct RecordedDevice {
    std::string name {}, model {}, serial {};
    std::optional<SceneFrame>
        frame {}; ///< at the first tick; version 1 of the formats had none, but a pointer's is known
};

struct MotionRecording {
    double rate_hz = 1000.0; ///< nominal
    std::vector<RecordedDevice> devices;
    std::vector<double> times_s; ///< one per tick, increasing
    std::vector<MotionSample> samples; ///< tick by tick, in each tick device by device

    [[nodiscard]] std::size_t tick_count() const noexcept { return times_s.size(); }
    [[nodiscard]] const MotionSample& at(std::size_t tick, std::size_t device) const noexcept
    {
        return samples[tick * devices.size() + device];
    }
};

/// Gives every pointer, and every replay of one, the frame in which it moved: the scene's own. Version 1 of the formats
/// tells no frame.
void place_pointers(MotionRecording& recording);

/// Fills a recording from inside the tick: room for all ticks is taken beforehand.
class MotionRecorder {
public:
    /// @throws InputError when there is no device or no room asked for
    MotionRecorder(std::vector<RecordedDevice> devices, double rate_hz, std::size_t max_ticks);

    /// Servo thread: no tick was added yet, and lies_at() is to be called.
    [[nodiscard]] bool empty() const noexcept { return recording_.times_s.empty(); }
    /// Where a device stands in the scene at the first tick. Allocates nothing.
    void lies_at(std::size_t device, const SceneFrame& frame) noexcept { recording_.devices[device].frame = frame; }
    /// Allocates nothing. A tick beyond the room is counted, not kept.
    /// @pre one sample per device; times increase
    void add(double time_s, std::span<const MotionSample> samples) noexcept;
    [[nodiscard]] std::size_t lost_ticks() const noexcept { return lost_; }
    /// When no tick runs any more.
    [[nodiscard]] const MotionRecording& recording() const noexcept { return recording_; }

private:
    MotionRecording recording_;
    std::size_t max_ticks_, lost_ = 0;
};

} // namespace retractor::haptics
