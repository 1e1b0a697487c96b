#pragma once
// The mouse as a device: a place in space that a view computes. The mouse cannot push, so a view shows the force
// instead. Events arrive about sixty times a second; between events the tip glides. Units mm, s.

#include "haptics/device/device.h"
#include "mesh/base/triple_buffer.h"

namespace retractor::haptics {

struct PointerOptions {
    double time_s = 0.02; ///< time constant with which the tip follows the pointer, so that events make no blows
    Workspace workspace { Vec3(-200.0, -200.0, -200.0), Vec3(200.0, 200.0, 200.0) }; ///< mm
};

class PointerDevice : public Device {
public:
    /// @throws InputError when the time is not positive or the workspace is empty
    explicit PointerDevice(const PointerOptions& options = {}, const DeviceInfo& info = { .name = "pointer" });

    // The window's thread:
    /// Sets a place in space, mm, limited to the workspace. Ignores values that are not finite.
    void point_at(const Vec3& place);
    /// Moves the tip as if it were lifted and set down: at rest, by at most kHop mm a tick. The tip glides on from
    /// there to a later point_at(), even when point_at() comes before the hop is finished.
    void hop_to(const Vec3& place);

    // Servo thread:
    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    DeviceReading read(double time_s, double step_s) noexcept override;
    /// @return zero, because a mouse cannot push
    Vec3 write(const Vec3& force) noexcept override;

    static constexpr double kHop = 80.0; ///< mm; less than the jump that a servo takes for a fault

private:
    struct Target {
        Vec3 position = Vec3::Zero();
        Vec3 landing = Vec3::Zero(); ///< landing place of the last hop
        std::uint64_t hops = 0; ///< number of requested hops
    };
    void publish();

    double time_s_;
    DeviceInfo info_;
    Target pointed_; ///< target as the window's thread set it
    TripleBuffer<Target> target_;
    std::uint64_t hops_done_ = 0; ///< number of finished hops; servo thread
    Vec3 position_;
};

} // namespace retractor::haptics
