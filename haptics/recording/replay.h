#pragma once
// A recorded motion as a device: the same hand again, at any tick rate.

#include "haptics/device/device.h"
#include "haptics/recording/motion_recording.h"

namespace retractor::haptics {

enum class ReplayMode {
    position, ///< the recorded positions, whatever force there is
    force, ///< the recorded hand force (what held against the applied force) pushes the stylus, and so does ours
};

struct ReplayOptions {
    ReplayMode mode = ReplayMode::position;
    bool repeat = false; ///< from the start again at the end; otherwise the last pose stays
    double stylus_mass = 45e-6; ///< tonne; force mode
    double stylus_damping = 5e-3; ///< N s/mm; force mode: nothing else brings the stylus to rest
};

class ReplayDevice : public Device {
public:
    /// @throws InputError when the recording has no such device or no tick
    ReplayDevice(MotionRecording recording, std::size_t device, const ReplayOptions& options = {});

    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    DeviceReading read(double time_s, double step_s) noexcept override;
    Vec3 write(const Vec3& force) noexcept override;
    [[nodiscard]] double duration_s() const noexcept;
    /// Where the device stood in the scene it was recorded in, where the recording tells.
    [[nodiscard]] const std::optional<SceneFrame>& frame() const noexcept { return recording_.devices[device_].frame; }

private:
    [[nodiscard]] MotionSample sample_at(double time_s) noexcept;

    MotionRecording recording_;
    std::size_t device_;
    ReplayOptions options_;
    DeviceInfo info_;
    std::size_t cursor_ = 0; ///< the tick at or before the last time asked for
    Vec3 position_, velocity_ = Vec3::Zero(); ///< force mode
    Vec3 force_ = Vec3::Zero();
};

} // namespace retractor::haptics
