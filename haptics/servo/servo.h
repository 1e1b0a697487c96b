#pragma once
// The loop between devices and tissue. In each tick the servo reads all devices, asks the tissue once with all
// fingertips, and writes a force to every device. The servo limits each force, observes its energy, and fades all
// forces out at a fault.

#include "haptics/recording/motion_recording.h"
#include "haptics/servo/device_mapping.h"
#include "haptics/servo/finger_coupling.h"
#include "haptics/servo/passivity.h"
#include "haptics/servo/servo_fault.h"
#include "haptics/servo/tissue_response.h"
#include "mesh/base/triple_buffer.h"

#include <array>
#include <atomic>
#include <vector>

namespace retractor::haptics {

/// A fingertip on a device: a single fingertip on the stylus, or several on a hand that the stylus carries.
struct FingerMount {
    std::size_t device = 0; ///< index of the device
    Vec3 offset = Vec3::Zero(); ///< offset from the device's tip, in the axes of the stylus, scene mm
    double radius = 4.0; ///< mm
};

struct ServoDevice {
    Device* device = nullptr; ///< must outlive the servo
    MappingOptions mapping = {};
};

struct ServoOptions {
    std::vector<FingerMount> fingers; ///< empty: one fingertip on the tip of each device
    CouplingOptions coupling;
    PassivityOptions passivity;
    bool watch_passivity = true; ///< off only to measure the effect of the controller
    FaultOptions faults;
    double force_gain = 1.0; ///< factor on all forces before every limit; a view shows the factor when it is not 1
    double step_s = 1e-3; ///< nominal period of a tick, s
};

constexpr std::size_t kMaxFingers = 8;

/// The result of a tick for the simulation and the view.
struct ServoState {
    std::uint64_t ticks = 0;
    double time_s = 0.0;
    std::size_t finger_count = 0;
    std::array<Fingertip, kMaxFingers> fingers; ///< positions of the hands, scene frame
    std::array<FingerContact, kMaxFingers> contacts;
    std::array<Vec3, kMaxFingers> forces; ///< wanted force on each finger, scene frame, N
    std::array<std::uint32_t, kMaxFingers> buttons; ///< pressed buttons of each finger's device
    double force_share = 0.0; ///< share of the force that is written: less than 1 during a ramp
    Fault fault;
};

class Servo : public Ticked {
public:
    /// @throws InputError when there is no device, a finger's device does not exist, there are more than kMaxFingers
    /// fingers, or the response takes another number of fingers
    Servo(std::vector<ServoDevice> devices, TissueResponse& response, const ServoOptions& options = {});

    /// Any thread: records every tick from the next tick on. A running tick may still write to a recorder that was
    /// replaced; the old recorder is free when latest() shows a later tick.
    /// @throws InputError when the recorder is for another number of devices
    void record_to(MotionRecorder* recorder);
    /// Devices for a new recorder. The first recorded tick sets their frames in the scene.
    [[nodiscard]] std::vector<RecordedDevice> recorded_devices() const;

    /// Servo thread. Allocates nothing, takes no lock, throws nothing.
    void tick(double time_s, double step_s) noexcept override;

    /// One other thread: the newest state.
    const ServoState& latest() noexcept { return state_.latest(); }
    /// Any thread: clears a fault at the next tick; the force ramps up again. A device that jumped places its fingers
    /// anew (Fingertip::placed) at its present position.
    void rearm() noexcept { rearm_.store(true, std::memory_order_relaxed); }
    /// Any thread: ends the session; the force ramps down as at a fault.
    void let_go() noexcept { let_go_.store(true, std::memory_order_relaxed); }

    /// @pre no tick runs
    [[nodiscard]] const PassivityController& passivity(std::size_t device) const
    {
        return channels_.at(device).passivity;
    }
    [[nodiscard]] const Coupling& coupling(std::size_t finger) const { return couplings_.at(finger).coupling(); }

private:
    /// The state of one device.
    struct DeviceChannel {
        Device* device;
        DeviceMapping mapping;
        PassivityController passivity;
        DeviceReading reading = {}; ///< pose that the tissue is asked with
        DeviceReading told = {}; ///< pose that is recorded: the last valid reading, also while the finger is away
        bool has_pose = false, touching = false;
        bool landing = false; ///< armed again after a jump: the next pose is placed
        bool placed = false; ///< the pose is the first after a jump
        /// The device jumped: until the servo is armed again, the tissue sees the pose before the jump.
        bool away = false;
        /// Time without a new reading, s.
        double silent_s = 0.0;
        double share = 1.0; ///< share of the force: zero while the clutch is pressed
        double heat = 0.0; ///< heat of the motors: time integral of (force / continuous force)^2 - 1, s
        /// Energy that the fingers have stored in the tissue if the tissue is linear, N mm of the device.
        double stored = 0.0;
        Vec3 wanted = Vec3::Zero(); ///< force before limits, device frame, N
        Vec3 held = Vec3::Zero(); ///< last wanted force before a fault, device frame, N
    };

    void read_devices(double time_s, double step_s) noexcept;
    void check(std::size_t device, const DeviceReading& reading, double time_s, double step_s) noexcept;
    void ask_tissue(double time_s, double step_s) noexcept;
    void write_devices(double time_s, double step_s) noexcept;
    void record(MotionRecorder& recorder, double time_s) noexcept;
    Vec3 limited(DeviceChannel& channel, const Vec3& force, double step_s) noexcept;
    void latch(FaultKind kind, std::size_t device, double time_s, double value = 0.0) noexcept;

    std::vector<DeviceChannel> channels_;
    TissueResponse& response_;
    ServoOptions options_;
    std::vector<FingerCoupling> couplings_;
    FaultLatch latch_;
    std::uint64_t ticks_ = 0;
    std::vector<Fingertip> fingers_, asked_;
    std::vector<FingerContact> contacts_;
    std::vector<Vec3> forces_;
    std::vector<MotionSample> samples_;
    std::atomic<MotionRecorder*> recorder_ { nullptr };
    std::atomic<bool> rearm_ { false }, let_go_ { false };
    TripleBuffer<ServoState> state_;
};

} // namespace retractor::haptics
