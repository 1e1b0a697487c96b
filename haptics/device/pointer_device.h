#pragma once
// The mouse as a device: the pointer's place in a plane and the wheel for the depth, or a place in space that a view
// makes of them. It cannot push, so a view shows the force instead. Events come some sixty times a second; between them
// the tip glides.

#include "haptics/device/device.h"
#include "mesh/base/triple_buffer.h"

namespace retractor::haptics {

struct PointerOptions {
    double time_s = 0.02; ///< the tip follows the pointer with this time constant: events make no blows
    Workspace workspace { Vec3(-200.0, -200.0, -200.0), Vec3(200.0, 200.0, 200.0) }; ///< mm
};

class PointerDevice : public Device {
public:
    /// @throws InputError when the time is not positive or the workspace is empty
    explicit PointerDevice(const PointerOptions& options = {}, const DeviceInfo& info = { .name = "pointer" });

    // One thread: the window's.
    /// Where the pointer is in the plane, mm; kept within the workspace. Not finite: left out.
    void point_at(double x, double y);
    /// A place in space, kept and refused alike.
    void point_at(const Vec3& place);
    /// The same without a way: the tip is lifted, taken there and set down at rest, kHop mm in a tick. What it is
    /// pointed at afterwards it glides to from there, also when that comes before the hop is done.
    void hop_to(const Vec3& place);
    /// Further away (positive) or nearer.
    void turn_wheel(double mm);
    /// Bit 0 is the first button.
    void press(std::uint32_t buttons);

    // Servo thread.
    [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
    DeviceReading read(double time_s, double step_s) noexcept override;
    /// @return nothing: a mouse pushes nobody
    Vec3 write(const Vec3& force) noexcept override;

    static constexpr double kHop = 80.0; ///< mm: less than what a servo takes for a fault

private:
    struct Target {
        Vec3 position = Vec3::Zero();
        std::uint32_t buttons = 0;
        Vec3 landing = Vec3::Zero(); ///< of the last hop
        std::uint64_t hops = 0; ///< asked for so far
    };
    void go_to(const Vec3& place);
    void publish();

    double time_s_;
    DeviceInfo info_;
    Target pointed_; ///< the window's
    TripleBuffer<Target> target_;
    std::uint64_t hops_done_ = 0; ///< the servo's
    Vec3 position_;
};

} // namespace retractor::haptics
