#pragma once
// The loop between devices and tissue: in each tick all devices are read, the tissue is asked once with all fingertips,
// and every device is given its force, limited, watched for energy, and let go at a fault.

#include "haptics/recording/motion_recording.h"
#include "haptics/servo/device_mapping.h"
#include "haptics/servo/finger_coupling.h"
#include "haptics/servo/passivity.h"
#include "haptics/servo/servo_fault.h"
#include "haptics/servo/tissue_response.h"
#include "mesh/base/triple_buffer.h"

#include <array>
#include <atomic>
#include <memory>
#include <vector>

namespace retractor::haptics {

/// A fingertip on a device: one on its stylus, or several on the hand that it carries.
struct FingerMount {
    std::size_t device = 0;
    Vec3 offset = Vec3::Zero(); ///< from the device's tip, in the stylus' axes, scene mm
    double radius = 4.0; ///< mm
};

struct ServoDevice {
    Device* device = nullptr; ///< lives longer than the servo
    MappingOptions mapping = {};
};

struct ServoOptions {
    std::vector<FingerMount> fingers; ///< empty: one on each device's tip
    CouplingOptions coupling;
    PassivityOptions passivity;
    bool watch_passivity = true; ///< off only to measure what it does
    FaultOptions faults;
    double force_gain = 1.0; ///< of all forces, before every limit: show it when it is not 1
    double step_s = 1e-3; ///< nominal
};

constexpr std::size_t kMaxFingers = 8;

/// What a tick leaves for the simulation and the view.
struct ServoState {
    std::uint64_t ticks = 0;
    double time_s = 0.0;
    std::size_t finger_count = 0;
    std::array<Fingertip, kMaxFingers> fingers; ///< where the hands are, scene frame
    std::array<FingerContact, kMaxFingers> contacts;
    std::array<Vec3, kMaxFingers> forces; ///< asked for, on each finger, scene frame, N
    std::array<std::uint32_t, kMaxFingers> buttons; ///< of each finger's device
    double force_share = 0.0; ///< that goes out: less than 1 while ramping
    Fault fault;
};

class Servo : public Ticked {
public:
    /// @throws InputError when there is no device, a finger's device does not exist, there are more than kMaxFingers,
    /// or the response takes another number of fingers
    Servo(std::vector<ServoDevice> devices, TissueResponse& response, const ServoOptions& options = {});

    /// Any thread: keeps every tick from the next one on. A recorder that was taken away may still be written to by
    /// the tick that is going on: it is free when latest() is of a later one.
    /// @throws InputError when the recorder is for another number of devices
    void record_to(MotionRecorder* recorder);
    /// For a recorder; where they stand in the scene it is told by the first tick that it keeps.
    [[nodiscard]] std::vector<RecordedDevice> recorded_devices() const;

    /// Servo thread. Allocates nothing, takes no lock, throws nothing.
    void tick(double time_s, double step_s) noexcept override;

    /// One other thread: the newest state.
    const ServoState& latest() noexcept { return state_.latest(); }
    /// Any thread: clears a fault at the next tick; the force comes back slowly. A device that jumped is a finger that
    /// is placed anew (Fingertip::placed), wherever its device is by now.
    void rearm() noexcept { rearm_.store(true, std::memory_order_relaxed); }
    /// Any thread: lets go for good, as at a fault, for a clean end.
    void let_go() noexcept { let_go_.store(true, std::memory_order_relaxed); }

    /// When no tick runs.
    [[nodiscard]] const PassivityController& passivity(std::size_t device) const
    {
        return channels_.at(device).passivity;
    }
    [[nodiscard]] const Coupling& coupling(std::size_t finger) const { return couplings_.at(finger).coupling(); }

private:
    /// All that belongs to one device.
    struct DeviceChannel {
        Device* device;
        DeviceMapping mapping;
        PassivityController passivity;
        DeviceReading reading = {}; ///< what the tissue is asked with
        DeviceReading told = {}; ///< what is recorded: the last possible reading, also while the finger is away
        bool has_pose = false, touching = false;
        bool landing = false; ///< armed again after a jump: its next pose is placed
        bool placed = false; ///< its pose is the first since then
        bool away = false; ///< it jumped: until the servo is armed again, the tissue sees it where it was
        double silent_s = 0.0;
        double share = 1.0; ///< of its force: none while the clutch is held
        double heat = 0.0; ///< s of continuous force beyond what it bears
        double stored = 0.0; ///< N mm of the device that its fingers have pressed into the tissue, were it linear
        Vec3 wanted = Vec3::Zero(); ///< N, device frame, before limits
        Vec3 held = Vec3::Zero(); ///< the last wanted before a fault
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
