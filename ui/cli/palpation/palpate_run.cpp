#include "ui/cli/palpation/palpate_run.h"

#include "haptics/device/udp_bridge.h"
#include "haptics/servo/device_mapping.h"
#include "haptics/servo/servo.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <optional>
#include <thread>

namespace retractor::ui::cli {

namespace {

    constexpr double kClear = 8.0; // mm above the surface at which a hand starts and ends
    constexpr double kLiveClear = 2.0; // mm above the surface at which the middle of a real device's workspace lies
    constexpr double kApproach = 1.0, kRelease = 0.5; // s
    constexpr int kFollowEvery = 16; // ticks: a display's 60 Hz

    double cycle(const PressPlan& plan) { return kApproach + plan.seconds + kRelease; }

    /// Records every tick of a servo. It is filled by the servo's thread, and read when this thread has stopped.
    class TickLog : public haptics::Ticked {
    public:
        TickLog(haptics::Servo& servo, std::size_t fingers, std::size_t room)
            : servo_(servo)
            , fingers_(fingers)
        {
            entries_.reserve(room * fingers);
        }
        struct Entry {
            double time = 0.0;
            haptics::Fingertip finger;
            haptics::FingerContact contact;
            double hand_force = 0.0;
        };

        void tick(double time_s, double step_s) noexcept override
        {
            servo_.tick(time_s, step_s);
            const haptics::ServoState& state = servo_.latest();
            double depth = 0.0;
            for (std::size_t f = 0; f < fingers_; ++f) {
                depth += state.contacts[f].touching ? state.contacts[f].depth : 0.0;
                if (entries_.size() < entries_.capacity())
                    entries_.push_back({ state.time_s, state.fingers[f], state.contacts[f], state.forces[f].norm() });
            }
            depth_.store(depth, std::memory_order_relaxed);
            time_.store(time_s, std::memory_order_relaxed);
            if (state.fault.kind != kind_.load(std::memory_order_relaxed)) {
                fault_ = state.fault;
                kind_.store(state.fault.kind, std::memory_order_release);
            }
        }

        // Any thread.
        double depth() const noexcept { return depth_.load(std::memory_order_relaxed); }
        double time() const noexcept { return time_.load(std::memory_order_relaxed); }
        haptics::FaultKind fault_kind() const noexcept { return kind_.load(std::memory_order_acquire); }

        // When no tick runs.
        const std::vector<Entry>& entries() const { return entries_; }
        const haptics::Fault& fault() const { return fault_; }

    private:
        haptics::Servo& servo_;
        std::size_t fingers_;
        std::vector<Entry> entries_;
        haptics::Fault fault_;
        std::atomic<double> depth_ { 0.0 }, time_ { 0.0 };
        std::atomic<haptics::FaultKind> kind_ { haptics::FaultKind::none };
    };

    long late_columns(const haptics::TissueResponse& tissue)
    {
        const auto* condensed = dynamic_cast<const haptics::CondensedTissue*>(&tissue);
        return condensed == nullptr ? 0 : condensed->late_ticks();
    }

    /// The state of the simulation thread while the servo ticks.
    struct Follower {
        haptics::TissueResponse& tissue;
        PressLog& log;
        double deepest = -1.0;
        Points deformed;

        void follow(double depth, double time)
        {
            tissue.follow(deformed);
            if (depth > deepest) {
                deepest = depth;
                log.deformed = deformed;
                deepest_time = time;
            }
        }
        double deepest_time = 0.0;
    };

    void run_steps(TickLog& ticks, Follower& follower, std::uint64_t count, const std::string& name, const Job& job)
    {
        for (std::uint64_t tick = 0; tick < count && !job.cancelled(); ++tick) {
            haptics::run_ticks(ticks, 1, kPalpateStep, tick);
            if (ticks.fault_kind() != haptics::FaultKind::none)
                throw SolverError("the forces were switched off: " + haptics::describe(ticks.fault()), name);
            if (tick % kFollowEvery != 0)
                continue;
            follower.follow(ticks.depth(), ticks.time());
            job.report("palpate " + name, static_cast<double>(tick) / static_cast<double>(count));
        }
    }

    bool passes(haptics::FaultKind kind)
    {
        return kind == haptics::FaultKind::late || kind == haptics::FaultKind::silent
            || kind == haptics::FaultKind::over_limit;
    }

    /// Runs the servo in real time. A passing fault is counted and the force returns; any other fault ends the run.
    void run_live(
        TickLog& ticks, haptics::Servo& servo, Follower& follower, HandDevices& hands, double seconds, const Job& job)
    {
        using Clock = std::chrono::steady_clock;
        constexpr std::chrono::milliseconds kFrame(16), kRearm(200), kFade(150);
        hands.rig().source().start(ticks);
        const auto begun = Clock::now();
        auto rearmed = begun;
        const auto since = [&] { return std::chrono::duration<double>(Clock::now() - begun).count(); };
        while (since() < seconds && !job.cancelled()) {
            std::this_thread::sleep_for(kFrame);
            follower.follow(ticks.depth(), ticks.time());
            const haptics::FaultKind fault = ticks.fault_kind();
            if (fault != haptics::FaultKind::none && !passes(fault))
                break;
            if (fault != haptics::FaultKind::none && Clock::now() > rearmed + kRearm) {
                follower.log.faults += 1;
                servo.rearm();
                rearmed = Clock::now();
            }
            job.report("palpate " + follower.log.name, since() / seconds);
        }
        const haptics::FaultKind fault = ticks.fault_kind();
        servo.let_go();
        std::this_thread::sleep_for(kFade);
        hands.rig().source().stop();
        follower.log.device_problems = hands.take_problems();
        if (fault != haptics::FaultKind::none && !passes(fault))
            follower.log.fault = haptics::describe(ticks.fault());
        for (const haptics::Device* device : hands.devices())
            if (const auto* far = dynamic_cast<const haptics::UdpDevice*>(device);
                far != nullptr && far->received() == 0)
                throw IoError("the other computer sent nothing: check that retractor relay runs there with the address "
                              "of this computer",
                    "udp port " + std::to_string(far->port()));
    }

    void keep(
        PressLog& log, const TickLog& ticks, const haptics::PulsePressure* pressure, double gain, double deepest_time)
    {
        const std::size_t fingers = log.fingers.size();
        log.deepest.resize(fingers);
        for (std::size_t i = 0; i < ticks.entries().size(); ++i) {
            const TickLog::Entry& entry = ticks.entries()[i];
            FingerLog& finger = log.fingers[i % fingers];
            finger.time.push_back(entry.time);
            finger.pressure_mmHg.push_back(pressure == nullptr ? 0.0 : pressure->at(entry.time) / haptics::kMPaPerMmHg);
            finger.position.push_back(entry.finger.position);
            finger.depth.push_back(entry.contact.touching ? entry.contact.depth : 0.0);
            finger.stiffness.push_back(entry.contact.stiffness);
            finger.force.push_back(gain * entry.contact.force);
            finger.hand_force.push_back(gain * entry.hand_force);
            if (entry.time <= deepest_time)
                log.deepest[i % fingers] = entry.finger;
        }
        log.ticks = static_cast<long>(ticks.entries().size() / fingers);
    }

    struct Line {
        std::vector<haptics::ServoDevice> devices;
        haptics::ServoOptions options;
    };

    /// The frame of a recording that is to be played at its own place; nothing when the recording is placed like other
    /// devices.
    std::optional<haptics::SceneFrame> frame_to_keep(const HandDevices& hands, std::size_t f, ReplayAt at)
    {
        if (!hands.is_replay(f) || at == ReplayAt::site)
            return {};
        const std::optional<haptics::SceneFrame> frame = hands.recorded_frame(f);
        if (at == ReplayAt::recorded && !frame)
            throw InputError("the recording does not say where it was made: add --replay-at site",
                "finger " + std::to_string(f + 1));
        const bool scene = frame && frame->linear.isIdentity(0.0) && frame->offset.isZero(0.0);
        return at == ReplayAt::recorded || scene ? frame : std::nullopt;
    }

    Line line_of(const Press& press, const HandDevices& hands, const PressPlan& plan, double gain)
    {
        const double radius = plan.radius_mm;
        Line line;
        for (std::size_t f = 0; f < press.sites.size(); ++f) {
            const datasets::TouchSite& site = press.sites[f];
            const double above = hands.is_live(f) ? radius + kLiveClear : 0.0;
            line.options.fingers.push_back({ .device = f, .radius = radius });
            if (const auto frame = frame_to_keep(hands, f, plan.replay_at)) {
                line.devices.push_back(
                    { hands.devices()[f], haptics::mapping_of(*frame, hands.devices()[f]->info().workspace) });
                line.devices.back().mapping.mirrored = line.devices.back().mapping.mirrored != hands.is_mirrored(f);
                continue;
            }
            line.devices.push_back({ hands.devices()[f],
                { .scene_centre = site.point + above * site.outward,
                    .scene_from_device = haptics::standing_on(site.outward),
                    .mirrored = hands.is_mirrored(f) } });
        }
        line.options.force_gain = gain;
        return line;
    }

} // namespace

haptics::HandPath press_path(const PressPlan& plan)
{
    const auto up = [](double y) { return Vec3(0.0, y, 0.0); };
    const Vec3 away = up(plan.radius_mm + kClear), down = up(plan.radius_mm - plan.depth_mm);
    std::vector<haptics::HandKey> keys { { 0.0, away, 0 } };
    for (int i = 0; i < plan.times; ++i) {
        const auto [from, to] = held_between(plan, i);
        keys.push_back({ from, down, 0 });
        keys.push_back({ to, down, 0 });
        keys.push_back({ to + kRelease, away, 0 });
    }
    return haptics::HandPath(keys);
}

std::pair<double, double> held_between(const PressPlan& plan, int time)
{
    const double from = kApproach + time * cycle(plan);
    return { from, from + plan.seconds };
}

std::vector<std::string> one_per_finger(const std::vector<std::string>& names, const Press& press)
{
    if (names.size() == press.sites.size())
        return names;
    if (names.size() != 1)
        throw InputError(std::to_string(names.size()) + " devices for " + std::to_string(press.sites.size())
                + " fingers: give one per finger, or one for all",
            "--device");
    if (is_live_hand(names[0]) && press.sites.size() > 1)
        throw InputError(std::to_string(press.sites.size()) + " fingers need as many devices", "--device");
    return std::vector<std::string>(press.sites.size(), names[0]);
}

PressLog run_press(const Press& press, haptics::TissueResponse& tissue, const std::vector<std::string>& device_names,
    const PressPlan& plan, const haptics::PulsePressure* pressure, double force_gain, const Job& job)
{
    HandDevices hands(one_per_finger(device_names, press), press_path(plan));
    RETRACTOR_ASSERT(hands.devices().size() == press.sites.size());
    Line line = line_of(press, hands, plan, force_gain);
    RETRACTOR_ASSERT(line.devices.size() == line.options.fingers.size());
    PressLog log;
    log.name = press.name;
    for (const datasets::TouchSite& site : press.sites)
        log.fingers.push_back({ site.name, {}, {}, {}, {}, {}, {}, {} });
    const double seconds = std::max(plan.times * cycle(plan), hands.replay_seconds());
    const auto ticks = static_cast<std::uint64_t>(std::llround(seconds / kPalpateStep));
    haptics::Servo servo(line.devices, tissue, line.options);
    constexpr std::size_t kSpare = 1000; // ticks for the fading of a live run
    haptics::MotionRecorder recorder(servo.recorded_devices(), 1.0 / kPalpateStep, ticks + kSpare);
    servo.record_to(&recorder);
    TickLog tick_log(servo, press.sites.size(), ticks + kSpare);
    Follower follower { tissue, log, -1.0, {} };
    const long late_before = late_columns(tissue);
    if (hands.any_live())
        run_live(tick_log, servo, follower, hands, seconds, job);
    else
        run_steps(tick_log, follower, ticks, press.name, job);
    keep(log, tick_log, pressure, force_gain, follower.deepest_time);
    log.late_ticks = late_columns(tissue) - late_before;
    log.motion = recorder.recording();
    return log;
}

} // namespace retractor::ui::cli
