#include "haptics/servo/servo.h"

#include "haptics/device/pose_check.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace retractor::haptics {

namespace {

    constexpr double kClutchRamp = 0.05; ///< s; releasing the clutch inside tissue must not be a blow
    constexpr double kHeatRoom = 20.0; ///< s; time at sqrt(2) of the continuous force until the motors are spared

    /// Lower bound of the gain in the stiffness limits; without force no limit is needed.
    constexpr double kLeastGain = 1e-3;

    std::vector<FingerMount> mounts_of(const ServoOptions& options, std::size_t devices)
    {
        std::vector<FingerMount> mounts = options.fingers;
        if (mounts.empty())
            for (std::size_t device = 0; device < devices; ++device)
                mounts.push_back({ .device = device });
        return mounts;
    }

    void check_mounts(const std::vector<FingerMount>& mounts, std::size_t devices, const TissueResponse& response)
    {
        if (mounts.size() > kMaxFingers)
            throw InputError("there are " + std::to_string(mounts.size()) + " fingers, at most "
                + std::to_string(kMaxFingers) + " are possible");
        if (mounts.size() != response.finger_count())
            throw InputError("there are " + std::to_string(mounts.size()) + " fingers, but '"
                + std::string(response.name()) + "' takes " + std::to_string(response.finger_count()));
        for (std::size_t i = 0; i < mounts.size(); ++i) {
            if (mounts[i].device >= devices)
                throw InputError(
                    "device " + std::to_string(mounts[i].device) + " does not exist", "finger " + std::to_string(i));
            if (!(mounts[i].radius > 0.0) || !std::isfinite(mounts[i].radius) || !mounts[i].offset.allFinite())
                throw InputError("the fingertip's radius or place is wrong", "finger " + std::to_string(i));
        }
    }

} // namespace

Servo::Servo(std::vector<ServoDevice> devices, TissueResponse& response, const ServoOptions& options)
    : response_(response)
    , options_(options)
    , latch_(options.faults)
{
    if (devices.empty())
        throw InputError("a servo needs at least one device");
    options_.fingers = mounts_of(options, devices.size());
    check_mounts(options_.fingers, devices.size(), response);
    if (!(options.step_s > 0.0) || !std::isfinite(options.step_s) || !(options.force_gain >= 0.0)
        || !std::isfinite(options.force_gain))
        throw InputError("the step must be positive, the force gain not negative, both finite");
    for (const ServoDevice& d : devices) {
        RETRACTOR_ASSERT(d.device != nullptr);
        const DeviceInfo& info = d.device->info();
        channels_.push_back({ .device = d.device,
            .mapping = DeviceMapping(d.mapping, info.workspace),
            .passivity = PassivityController(info.limits, options.passivity) });
    }
    for (const FingerMount& mount : options_.fingers) {
        const DeviceChannel& channel = channels_[mount.device];
        DeviceLimits limits = channel.device->info().limits;
        limits.resolution *= channel.mapping.options().scale;
        couplings_.emplace_back(options.coupling, limits, options.step_s,
            channel.mapping.stiffness_gain() * std::max(options.force_gain, kLeastGain));
    }
    fingers_.resize(options_.fingers.size());
    asked_ = fingers_;
    contacts_.resize(fingers_.size());
    forces_.assign(fingers_.size(), Vec3::Zero());
    samples_.resize(channels_.size());
    RETRACTOR_ASSERT(couplings_.size() == fingers_.size() && fingers_.size() <= kMaxFingers);
}

void Servo::record_to(MotionRecorder* recorder)
{
    if (recorder != nullptr && recorder->recording().devices.size() != channels_.size())
        throw InputError("the recorder is for " + std::to_string(recorder->recording().devices.size())
            + " devices, not " + std::to_string(channels_.size()));
    recorder_.store(recorder, std::memory_order_release);
}

std::vector<RecordedDevice> Servo::recorded_devices() const
{
    std::vector<RecordedDevice> devices;
    for (const DeviceChannel& channel : channels_) {
        const DeviceInfo& info = channel.device->info();
        devices.push_back({ info.name, info.model, info.serial });
    }
    return devices;
}

void Servo::latch(FaultKind kind, std::size_t device, double time_s, double value) noexcept
{
    latch_.latch({ .kind = kind, .device = device, .tick = ticks_, .time_s = time_s, .value = value });
}

void Servo::check(std::size_t device, const DeviceReading& reading, double time_s, double step_s) noexcept
{
    RETRACTOR_ASSERT(device < channels_.size());
    DeviceChannel& channel = channels_[device];
    channel.placed = false;
    const FaultOptions& limits = options_.faults;
    channel.silent_s = reading.trouble == DeviceTrouble::silent ? channel.silent_s + step_s : 0.0;
    if (reading.trouble == DeviceTrouble::over_limit)
        latch(FaultKind::over_limit, device, time_s);
    else if (reading.trouble == DeviceTrouble::lost)
        latch(FaultKind::lost, device, time_s);
    else if (channel.silent_s > limits.silence_s)
        latch(FaultKind::silent, device, time_s, channel.silent_s);
    const bool possible = reading.position.allFinite() && is_speed(reading.velocity)
        && is_rotation(Eigen::Quaterniond(reading.orientation));
    if (!possible) {
        latch(FaultKind::bad_position, device, time_s);
        channel.told.velocity.setZero(); // the pose stays the last valid pose
        channel.reading.velocity.setZero();
        return;
    }
    const double moved = channel.has_pose ? (reading.position - channel.told.position).norm() : 0.0;
    if (moved >= limits.jump_mm) {
        latch(FaultKind::jump, device, time_s, moved);
        channel.away = true; // else the finger would sweep through the tissue, with a lasting effect on springs
    }
    channel.told = reading;
    channel.placed = std::exchange(channel.landing, false);
    channel.has_pose = true;
    if (channel.away)
        channel.reading.velocity.setZero();
    else
        channel.reading = reading;
}

void Servo::read_devices(double time_s, double step_s) noexcept
{
    for (std::size_t d = 0; d < channels_.size(); ++d) {
        check(d, channels_[d].device->read(time_s, step_s), time_s, step_s);
        channels_[d].mapping.update(channels_[d].reading);
        channels_[d].wanted.setZero();
        channels_[d].stored = 0.0;
        channels_[d].touching = false;
    }
}

void Servo::ask_tissue(double time_s, double step_s) noexcept
{
    for (std::size_t f = 0; f < fingers_.size(); ++f) {
        const FingerMount& mount = options_.fingers[f];
        const DeviceChannel& channel = channels_[mount.device];
        fingers_[f].position = channel.mapping.to_scene(channel.reading.position)
            + channel.mapping.direction_to_scene(channel.reading.orientation * mount.offset);
        fingers_[f].velocity = channel.mapping.velocity_to_scene(channel.reading.velocity);
        fingers_[f].radius = mount.radius;
        fingers_[f].placed = channel.placed;
        if (channel.placed)
            couplings_[f].restart();
        asked_[f] = couplings_[f].asked(fingers_[f]);
    }
    response_.tick(time_s, step_s, asked_, contacts_);
    for (std::size_t f = 0; f < fingers_.size(); ++f) {
        DeviceChannel& channel = channels_[options_.fingers[f].device];
        const FingerContact& c = contacts_[f];
        const bool answered = c.force.allFinite()
            && (!c.touching || (c.proxy.allFinite() && c.normal.allFinite() && std::isfinite(c.stiffness)));
        forces_[f] = answered ? couplings_[f].force(fingers_[f], c, step_s) : Vec3(Vec3::Zero());
        Vec3 felt = channel.mapping.force_to_device(options_.force_gain * forces_[f]);
        // Finite contacts may still overflow in the coupling.
        const bool finite = answered && std::isfinite(felt.squaredNorm());
        if (!finite) {
            latch(FaultKind::bad_force, f, time_s);
            forces_[f].setZero();
            felt.setZero();
        }
        channel.wanted += felt;
        channel.stored += finite ? 0.5 * felt.norm() * c.depth / channel.mapping.options().scale : 0.0;
        channel.touching = channel.touching || c.touching;
    }
}

Vec3 Servo::limited(DeviceChannel& channel, const Vec3& force, double step_s) noexcept
{
    // The full force is allowed for a moment, the continuous force for any time. Heat grows with the squared force.
    const DeviceLimits& limits = channel.device->info().limits;
    const double load = force.squaredNorm() / (limits.continuous_force * limits.continuous_force);
    channel.heat = std::clamp(channel.heat + step_s * (load - 1.0), 0.0, kHeatRoom);
    const double cool = std::min(1.0, 2.0 - 2.0 * channel.heat / kHeatRoom);
    return clamped(force, limits.continuous_force + cool * (limits.max_force - limits.continuous_force));
}

void Servo::write_devices(double time_s, double step_s) noexcept
{
    const double gain = latch_.gain(step_s);
    for (std::size_t d = 0; d < channels_.size(); ++d) {
        DeviceChannel& channel = channels_[d];
        const double target = channel.mapping.clutched() ? 0.0 : 1.0;
        channel.share = target > channel.share ? std::min(target, channel.share + step_s / kClutchRamp)
                                               : std::max(target, channel.share - step_s / kClutchRamp);
        // After a fault no new force is trusted: the last force fades.
        if (!latch_.latched())
            channel.held = channel.wanted;
        Vec3 force = limited(channel, gain * channel.share * channel.held, step_s);
        if (gain * channel.share < 1.0)
            channel.passivity.restart(channel.stored);
        if (options_.watch_passivity && channel.has_pose)
            force = clamped(channel.passivity.control(
                                force, channel.reading.position, channel.reading.velocity, step_s, channel.touching),
                channel.device->info().limits.max_force);
        if (latch_.latched() && gain == 0.0)
            force.setZero();
        const Vec3 applied = channel.device->write(force);
        channel.passivity.written(applied);
        samples_[d] = { .position = channel.told.position,
            .orientation = Eigen::Quaterniond(channel.told.orientation),
            .velocity = channel.told.velocity,
            .commanded_force = channel.wanted,
            .applied_force = applied,
            .buttons = channel.told.buttons };
    }
    if (MotionRecorder* const recorder = recorder_.load(std::memory_order_acquire); recorder != nullptr)
        record(*recorder, time_s);
    ServoState& state = state_.draft();
    state.ticks = ticks_;
    state.time_s = time_s;
    state.finger_count = fingers_.size();
    for (std::size_t f = 0; f < fingers_.size(); ++f) {
        state.fingers[f] = fingers_[f];
        state.contacts[f] = contacts_[f];
        state.forces[f] = forces_[f];
        state.buttons[f] = channels_[options_.fingers[f].device].reading.buttons;
    }
    state.force_share = gain;
    state.fault = latch_.fault();
    state_.publish();
}

void Servo::record(MotionRecorder& recorder, double time_s) noexcept
{
    if (recorder.empty())
        for (std::size_t d = 0; d < channels_.size(); ++d)
            recorder.lies_at(d, channels_[d].mapping.frame(samples_[d].position));
    recorder.add(time_s, samples_);
}

void Servo::tick(double time_s, double step_s) noexcept
{
    ++ticks_;
    if (rearm_.exchange(false, std::memory_order_relaxed)) {
        latch_.rearm();
        for (DeviceChannel& channel : channels_)
            if (std::exchange(channel.away, false)) {
                channel.has_pose = false; // the next pose has no predecessor, so it is no jump
                channel.landing = true;
            }
    }
    if (let_go_.load(std::memory_order_relaxed))
        latch(FaultKind::let_go, 0, time_s);
    if (!(step_s > 0.0) || step_s > options_.faults.late_s) {
        latch(FaultKind::late, 0, time_s, step_s);
        step_s = options_.step_s; // a late tick must not shorten a ramp
    }
    RETRACTOR_ASSERT(step_s > 0.0);
    read_devices(time_s, step_s);
    ask_tissue(time_s, step_s);
    write_devices(time_s, step_s);
}

} // namespace retractor::haptics
