#pragma once
// The clock of a tick source, and its count of missed ticks. Units s.

#include <cstdint>

namespace retractor::haptics {

/// The measurements of a tick source.
struct TickTimes {
    std::uint64_t ticks = 0;
    std::uint64_t missed = 0; ///< number of whole periods in which no tick began
};

/// Monotonic clock, s.
double tick_clock_s() noexcept;

/// Measures ticks. Call begin() at the start of each tick.
class TickTimer {
public:
    using Clock = double (*)() noexcept;
    explicit TickTimer(double period_s, Clock clock = tick_clock_s)
        : period_(period_s)
        , clock_(clock)
    {
    }
    /// @return time since the last tick, s; the nominal period at the first tick
    double begin() noexcept;
    /// Start of this tick since the start of the first, s.
    [[nodiscard]] double time_s() const noexcept { return begun_ - first_; }
    [[nodiscard]] const TickTimes& times() const noexcept { return times_; }

private:
    double period_;
    Clock clock_;
    double first_ = 0.0, begun_ = 0.0;
    TickTimes times_;
};

} // namespace retractor::haptics
