#include "haptics/servo/passivity.h"

#include <algorithm>
#include <cmath>

namespace retractor::haptics {

namespace {

    constexpr double kDampedFrom = 0.5; ///< share of the allowance at which damping starts
    constexpr double kSofter = 0.9; ///< factor on the force each time the whole allowance came out in spite of damping
    constexpr double kRecovery = 2.0; ///< time in free space from zero to the full force, s

} // namespace

double damping_for_passivity(const Coupling& coupling, double step_s, int delay_ticks) noexcept
{
    return coupling.stiffness * step_s * (0.5 + delay_ticks) + std::abs(coupling.damping);
}

double passive_stiffness(const DeviceLimits& limits, double step_s) noexcept
{
    return limits.own_damping / (step_s * (0.5 + limits.delay_ticks));
}

Coupling within_limits(const Coupling& wanted, const DeviceLimits& limits, double step_s, double gain) noexcept
{
    Coupling felt { std::min(wanted.stiffness * gain, limits.max_stiffness),
        std::min(wanted.damping * gain, limits.max_damping) };
    if (limits.own_damping > 0.0) {
        felt.stiffness = std::min(felt.stiffness, passive_stiffness(limits, step_s));
        const double left
            = limits.own_damping - damping_for_passivity({ felt.stiffness, 0.0 }, step_s, limits.delay_ticks);
        felt.damping = std::min(felt.damping, std::max(0.0, left));
    }
    return { felt.stiffness / gain, felt.damping / gain };
}

PassivityController::PassivityController(const DeviceLimits& limits, const PassivityOptions& options)
    : limits_(limits)
    , options_(options)
    , delay_(std::min(static_cast<std::size_t>(std::max(limits.delay_ticks, 0)), kMaxDelay))
{
    held_.fill(Vec3::Zero());
}

Vec3 PassivityController::control(
    const Vec3& force, const Vec3& position, const Vec3& velocity, double step_s, bool touching) noexcept
{
    if (started_) {
        const Vec3 moved = position - last_;
        energy_ -= held_[delay_].dot(moved);
        energy_ += limits_.own_damping * moved.squaredNorm() / step_s + limits_.own_friction * moved.norm();
        // The power that living tissue may supply fills up missing energy, but never more.
        if (energy_ < 0.0)
            energy_ = std::min(0.0, energy_ + options_.active_power * step_s);
    }
    started_ = true;
    last_ = position;
    if (!touching) {
        energy_ = std::min(energy_, 0.0);
        share_ = std::min(1.0, share_ + step_s / kRecovery);
    }
    const double owed = -energy_ - kDampedFrom * options_.allowance;
    if (!(owed > 0.0))
        return share_ * force;
    if (-energy_ > options_.allowance) {
        share_ *= kSofter; // restart the count, because released energy cannot be recovered
        energy_ = -kDampedFrom * options_.allowance;
    }
    ++damped_ticks_;
    const double speed2 = velocity.squaredNorm();
    const double damping = speed2 > 0.0 ? std::min(owed / (step_s * speed2), limits_.max_damping) : 0.0;
    return share_ * force - damping * velocity;
}

void PassivityController::written(const Vec3& applied) noexcept
{
    std::copy_backward(held_.begin(), held_.end() - 1, held_.end());
    held_.front() = applied;
}

} // namespace retractor::haptics
