#pragma once
// A haptic device: pose, velocity and buttons in, force out. Vendors' schedulers call us, so a device does not own the
// loop: a TickSource runs a tick function about every millisecond, and within one tick all devices of a session are
// read, then all are written (with a vendor's scheduler, separate callbacks per device interleave and only one device
// gets its force). Frame: the device's own: x to the right, y up, z towards the user; DeviceMapping takes it to the
// scene. Units mm, s, N, tonne.

#include "mesh/base/geometry.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace retractor::haptics {

/// What the hardware can do. Defaults: 3D Systems Touch, from its data sheet and the manufacturer's limits.
struct DeviceLimits {
    double max_force = 3.3; ///< N, for moments
    double continuous_force = 0.88; ///< N, for as long as one likes
    double max_stiffness = 1.02; ///< N/mm, of its softest axis (1.26, 2.31, 1.02)
    double max_damping = 5e-3; ///< N s/mm
    double own_damping = 0.0; ///< N s/mm that its mechanics dissipate for certain; 0 when unknown
    double own_friction = 0.0; ///< N, dry, for certain; 0 when unknown
    double resolution = 0.055; ///< mm
    int delay_ticks = 0; ///< between a force written and the motors
};

/// An axis-aligned box in the device's frame.
struct Workspace {
    Vec3 low { -80.0, -60.0, -35.0 }; ///< 160 x 120 x 70 mm
    Vec3 high { 80.0, 60.0, 35.0 };
};

struct DeviceInfo {
    std::string name; ///< as the user calls it
    std::string model = {};
    std::string serial = {};
    double rate_hz = 1000.0;
    DeviceLimits limits = {};
    Workspace workspace = {};
};

/// What may be wrong with a device, as it says itself.
enum class DeviceTrouble : std::uint8_t {
    none,
    silent, ///< nothing new has arrived for this tick
    over_limit, ///< motors warm, or force, impulse or velocity beyond what the device allows: it recovers when left
                ///< alone
    lost, ///< unplugged, or its driver reports a fault
};
std::string_view to_string(DeviceTrouble trouble) noexcept;

/// One device at one tick.
struct DeviceReading {
    Vec3 position = Vec3::Zero(); ///< of its tip, mm
    Vec3 velocity = Vec3::Zero(); ///< mm/s
    Mat3 orientation = Mat3::Identity(); ///< columns: the stylus' axes
    std::uint32_t buttons = 0; ///< bit 0 is the first button
    DeviceTrouble trouble = DeviceTrouble::none;
};

/// Entries of turn * turn^T may differ from those of the identity by this much; of a scaled rotation: times its scale
/// squared.
inline constexpr double kRotationTolerance = 1e-6;

/// A device's frame in the scene's, as files tell it: scene mm = linear * device mm + offset until the clutch is used.
/// `linear` is a rotation, mirrored or not, times a scale.
struct SceneFrame {
    Mat3 linear = Mat3::Identity();
    Vec3 offset = Vec3::Zero();
    std::uint32_t clutch_buttons = 0; ///< as MappingOptions
};
/// Why the frame is none; empty: it is one.
std::string problem_of(const SceneFrame& frame);

/// read() and write() belong to the tick: no allocation, lock, log or exception.
class Device {
public:
    Device() = default;
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    virtual ~Device();

    [[nodiscard]] virtual const DeviceInfo& info() const noexcept = 0;
    /// First in a tick. A reading with trouble repeats the last good pose.
    /// @param step_s since the tick before
    virtual DeviceReading read(double time_s, double step_s) noexcept = 0;
    /// Last in a tick: the force on the hand, N, in the device's frame; held until the next write.
    /// @return what the device makes of it after its own limits
    virtual Vec3 write(const Vec3& force) noexcept = 0;
};

/// What is run about every millisecond.
class Ticked {
public:
    virtual ~Ticked();
    /// @param time_s since the start; `step_s` since the tick before (the nominal period at the first one)
    virtual void tick(double time_s, double step_s) noexcept = 0;
};

/// What calls it: our own thread (tick_thread.h), a vendor's scheduler, or a test.
class TickSource {
public:
    virtual ~TickSource();
    /// @throws IoError when the thread or scheduler cannot be started; InputError when it already runs
    virtual void start(Ticked& ticked) = 0;
    /// Returns when no tick runs any more. Does nothing when it does not run.
    virtual void stop() noexcept = 0;
};

/// Ticks on the caller's thread, one after the other as fast as they go, at exact times: bit-exact on any machine.
/// @param first counts on from an earlier call
void run_ticks(Ticked& ticked, std::uint64_t count, double step_s = 1e-3, std::uint64_t first = 0);

/// `force` with its length cut to `limit`; NaN stays.
Vec3 clamped(const Vec3& force, double limit) noexcept;

} // namespace retractor::haptics
