#pragma once
// A haptic device: pose, velocity and buttons in, force out. Vendors' schedulers call our code, so a device does not
// own the loop: a TickSource runs a tick function about every millisecond. Within one tick all devices of a session are
// read, then all are written. (With separate scheduler callbacks per device, the callbacks interleave and only one
// device gets its force.) Frame: the device's own, with x to the right, y up, z towards the user; DeviceMapping maps
// this frame to the scene's. Units mm, s, N, tonne.

#include "mesh/base/geometry.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace retractor::haptics {

/// Limits of the hardware. Defaults: 3D Systems Touch, from its data sheet and the manufacturer's limits.
struct DeviceLimits {
    double max_force = 3.3; ///< largest force for a short time, N
    double continuous_force = 0.88; ///< largest force for any time, N
    double max_stiffness = 1.02; ///< N/mm, of the softest axis (1.26, 2.31, 1.02)
    double max_damping = 5e-3; ///< largest damping that the device may render, N s/mm
    double own_damping = 0.0; ///< guaranteed damping of the device's mechanics, N s/mm; 0 when unknown
    double own_friction = 0.0; ///< guaranteed dry friction of the device's mechanics, N; 0 when unknown
    double resolution = 0.055; ///< of the position, mm
    int delay_ticks = 0; ///< ticks between write() and the motors
};

/// An axis-aligned box in the device's frame.
struct Workspace {
    Vec3 low { -80.0, -60.0, -35.0 }; ///< 160 x 120 x 70 mm
    Vec3 high { 80.0, 60.0, 35.0 };
};

struct DeviceInfo {
    std::string name; ///< name that the user gives the device
    std::string model = {};
    std::string serial = {};
    double rate_hz = 1000.0;
    DeviceLimits limits = {};
    Workspace workspace = {};
};

/// A problem that a device reports.
enum class DeviceTrouble : std::uint8_t {
    none,
    silent, ///< no new reading has arrived for this tick
    /// Warm motors, or force, impulse or velocity beyond the device's limits; the device recovers without force.
    over_limit,
    lost, ///< unplugged, or its driver reports a fault
};
std::string_view to_string(DeviceTrouble trouble) noexcept;

/// The reading of one device at one tick, in the device's frame.
struct DeviceReading {
    Vec3 position = Vec3::Zero(); ///< position of the tip, mm
    Vec3 velocity = Vec3::Zero(); ///< mm/s
    Mat3 orientation = Mat3::Identity(); ///< columns: axes of the stylus
    std::uint32_t buttons = 0; ///< bit 0 is the first button
    DeviceTrouble trouble = DeviceTrouble::none;
};

/// Largest difference between an entry of turn * turn^T and of the identity in a rotation. For a scaled rotation the
/// tolerance is multiplied by the squared scale.
inline constexpr double kRotationTolerance = 1e-6;

/// A device's frame in the scene's, as files store it: scene mm = linear * device mm + offset, until the clutch is
/// used. `linear` is a rotation, mirrored or not, times a scale.
struct SceneFrame {
    Mat3 linear = Mat3::Identity();
    Vec3 offset = Vec3::Zero(); ///< mm
    std::uint32_t clutch_buttons = 0; ///< mask of buttons, as in MappingOptions
};
/// The reason why `frame` is invalid; empty when the frame is valid.
std::string problem_of(const SceneFrame& frame);

/// A haptic device. read() and write() belong to the tick: they allocate nothing, take no lock, write no log and throw
/// nothing.
class Device {
public:
    Device() = default;
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    virtual ~Device();

    [[nodiscard]] virtual const DeviceInfo& info() const noexcept = 0;
    /// Called first in a tick. A reading with trouble repeats the last good pose.
    /// @param time_s time since the start
    /// @param step_s time since the last tick
    virtual DeviceReading read(double time_s, double step_s) noexcept = 0;
    /// Called last in a tick: sets the force on the hand, N, in the device's frame. The force stays until the next
    /// write().
    /// @return the force after the device's own limits
    virtual Vec3 write(const Vec3& force) noexcept = 0;
};

/// A function that runs about every millisecond.
class Ticked {
public:
    virtual ~Ticked();
    /// @param time_s time since the start
    /// @param step_s time since the last tick; the nominal period at the first tick
    virtual void tick(double time_s, double step_s) noexcept = 0;
};

/// Calls a Ticked about every millisecond: our own thread (tick_thread.h), a vendor's scheduler, or a test.
class TickSource {
public:
    virtual ~TickSource();
    /// @throws IoError when the thread or scheduler cannot be started; InputError when the source runs already
    virtual void start(Ticked& ticked) = 0;
    /// Returns when no tick runs any more. Does nothing when the source does not run.
    virtual void stop() noexcept = 0;
};

/// Runs ticks on the caller's thread without waiting, at exact times. The result is bit-exact on any machine.
/// @param first number of the first tick, to continue an earlier call
void run_ticks(Ticked& ticked, std::uint64_t count, double step_s = 1e-3, std::uint64_t first = 0);

/// `force` with its length limited to `limit`; NaN stays NaN.
Vec3 clamped(const Vec3& force, double limit) noexcept;

} // namespace retractor::haptics
