#pragma once
// A recorded motion as a device. The device repeats the recorded positions whatever the force, at any tick rate. After
// the end the last pose stays.

#include "haptics/device/device.h"
#include "haptics/recording/motion_recording.h"

namespace retractor::haptics {

class ReplayDevice : public Device {
public:
    /// @throws InputError when the recording has no such device or no tick
    ReplayDevice(MotionRecording recording, std::size_t device);

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    DeviceReading read(double time_s, double step_s) noexcept override;
    Vec3 write(const Vec3& force) noexcept override;
    [[nodiscard]] double duration_s() const noexcept;
    /// Frame of the device in the scene of the recording, when the recording has one.
    [[nodiscard]] const std::optional<SceneFrame>& frame() const noexcept { return recording_.devices[device_].frame; }

private:
    [[nodiscard]] MotionSample sample_at(double time_s) noexcept;

    MotionRecording recording_;
    std::size_t device_;
    DeviceInfo info_;
    std::size_t cursor_ = 0; ///< last tick at or before the last requested time
};

} // namespace retractor::haptics
