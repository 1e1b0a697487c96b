#include "haptics/device/simulated_hand.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>

namespace retractor::haptics {

namespace {

    constexpr double kPerNewtonPerMetre = 1e-3; // N/m to N/mm, and N s/m to N s/mm
    constexpr double kPerKilogram = 1e-3; // kg to tonne

    void check_positive(const Vec3& value, const char* where)
    {
        if (!value.allFinite() || !(value.minCoeff() > 0.0))
            throw InputError("a hand's parameters must be positive", where);
    }

    void check_not_negative(double value, const char* where)
    {
        if (!std::isfinite(value) || value < 0.0)
            throw InputError("must not be negative", where);
    }

    void check(const SimulatedHandOptions& options, std::size_t max_delay)
    {
        check_positive(options.hand.grip_stiffness, "grip_stiffness");
        check_positive(options.hand.grip_damping, "grip_damping");
        check_positive(options.hand.mass, "mass");
        check_positive(options.hand.arm_stiffness, "arm_stiffness");
        check_positive(options.hand.arm_damping, "arm_damping");
        check_positive(Vec3::Constant(options.stylus_mass), "stylus_mass");
        check_not_negative(options.stylus_damping, "stylus_damping");
        check_not_negative(options.friction, "friction");
        if (options.delay_ticks > max_delay)
            throw InputError("the delay is longer than " + std::to_string(max_delay) + " ticks", "delay_ticks");
        if (options.substeps < 1)
            throw InputError("at least one step a tick is needed", "substeps");
    }

} // namespace

HandParameters relaxed_grip()
{
    return { .grip_stiffness = kPerNewtonPerMetre * Vec3(379.5, 552.4, 769.9),
        .grip_damping = kPerNewtonPerMetre * Vec3(1.839, 3.609, 0.776),
        .mass = kPerKilogram * Vec3(0.218, 0.269, 0.204),
        .arm_stiffness = kPerNewtonPerMetre * Vec3(78.75, 105.3, 271.7),
        .arm_damping = kPerNewtonPerMetre * Vec3(4.645, 6.430, 18.06) };
}

HandParameters firm_grip()
{
    return { .grip_stiffness = Vec3::Constant(kPerNewtonPerMetre * 1043.0),
        .grip_damping = Vec3::Constant(kPerNewtonPerMetre * 4.6),
        .mass = Vec3::Constant(kPerKilogram * 0.57),
        .arm_stiffness = Vec3::Constant(kPerNewtonPerMetre * 533.0),
        .arm_damping = Vec3::Constant(kPerNewtonPerMetre * 27.6) };
}

Vec3 quantised(const Vec3& position, double resolution) noexcept
{
    return resolution > 0.0 ? Vec3(resolution * (position / resolution).array().round()) : position;
}

SimulatedHand::SimulatedHand(const SimulatedHandOptions& options, const DeviceInfo& info)
    : options_(options)
    , info_(info)
    , tip_(options.path.position(0.0))
    , hand_(tip_)
    , velocity_(info.limits.resolution)
{
    check(options, kMaxDelay);
    if (info_.model.empty())
        info_.model = "simulated Touch with a hand on it";
    info_.limits.own_damping = options.stylus_damping;
    info_.limits.own_friction = options.friction;
    info_.limits.delay_ticks = static_cast<int>(options.delay_ticks);
    pending_.fill(Vec3::Zero());
}

void SimulatedHand::integrate(double from_s, double step_s) noexcept
{
    const HandParameters& h = options_.hand;
    // A late tick is integrated in small steps. Of a very long pause only the end is integrated, because the hand has
    // forgotten by then where it began.
    constexpr double kLongestStep = 2.5e-4, kLongestPause = 10.0;
    from_s += std::max(0.0, step_s - kLongestPause);
    step_s = std::min(step_s, kLongestPause);
    const int substeps = std::max(options_.substeps, static_cast<int>(std::ceil(step_s / kLongestStep)));
    const double dt = step_s / substeps;
    for (int i = 0; i < substeps; ++i) {
        const Vec3 target = options_.path.position(from_s + (i + 1) * dt);
        const Vec3 grip
            = h.grip_stiffness.cwiseProduct(hand_ - tip_) + h.grip_damping.cwiseProduct(hand_velocity_ - tip_velocity_);
        const Vec3 arm = h.arm_stiffness.cwiseProduct(target - hand_) - h.arm_damping.cwiseProduct(hand_velocity_);
        const Vec3 push = motor_ + grip - options_.stylus_damping * tip_velocity_;
        tip_velocity_ += dt / options_.stylus_mass * push;
        // Dry friction reduces the speed, at most to zero.
        const double speed = tip_velocity_.norm(), braked = dt / options_.stylus_mass * options_.friction;
        tip_velocity_ *= speed > braked ? 1.0 - braked / speed : options_.friction > 0.0 ? 0.0 : 1.0;
        hand_velocity_ += dt * (arm - grip).cwiseQuotient(h.mass);
        tip_ += dt * tip_velocity_;
        hand_ += dt * hand_velocity_;
    }
}

DeviceReading SimulatedHand::read(double time_s, double step_s) noexcept
{
    // Since the last write() the motors have held the force that was written `delay_ticks` earlier.
    motor_ = pending_.front();
    integrate(time_s - step_s, step_s);
    DeviceReading reading;
    reading.position = quantised(tip_, info_.limits.resolution);
    reading.velocity = velocity_.update(reading.position, step_s);
    reading.buttons = options_.path.buttons(time_s);
    return reading;
}

Vec3 SimulatedHand::write(const Vec3& force) noexcept
{
    const Vec3 applied = force.allFinite() ? clamped(force, info_.limits.max_force) : Vec3(Vec3::Zero());
    for (std::size_t i = 0; i < options_.delay_ticks; ++i)
        pending_[i] = pending_[i + 1];
    pending_[options_.delay_ticks] = applied;
    return applied;
}

} // namespace retractor::haptics
