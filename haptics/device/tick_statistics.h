#pragma once
// Regularity of a servo: histograms of periods and of compute times, filled inside the tick. Units s.

#include <array>
#include <cstdint>
#include <vector>

namespace retractor::haptics {

/// Counts of durations in bins from 100 ns to 10 s. There are twenty bins a decade, so a bin is 12 % wider than the one
/// before. Allocates nothing.
/// @pre the reading functions run only when nothing is added
class TickHistogram {
public:
    struct Bin {
        double low_s, high_s;
        std::uint64_t count;
    };

    void add(double seconds) noexcept;
    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
    /// Exact mean; 0 when empty.
    [[nodiscard]] double mean_s() const noexcept;
    [[nodiscard]] double max_s() const noexcept { return max_; }
    /// Upper end of the bin that contains this share of the counts, limited to the largest value. Never too small.
    [[nodiscard]] double percentile_s(double share) const noexcept;
    /// All bins from the first to the last that is not empty.
    [[nodiscard]] std::vector<Bin> bins() const;

private:
    static constexpr double kLow = 1e-7;
    static constexpr int kPerDecade = 20, kDecades = 8;
    static double edge(std::size_t bin);

    /// The first counts shorter durations, the last longer ones.
    std::array<std::uint64_t, kPerDecade * kDecades + 2> counts_ {};
    std::uint64_t count_ = 0;
    double sum_ = 0.0, max_ = 0.0;
};

/// The measurements of a tick source.
struct TickTimes {
    TickHistogram periods; ///< time from tick to tick
    TickHistogram jitter; ///< absolute difference between a period and the nominal period
    TickHistogram compute; ///< wall-clock time of a tick, including time that other programs took
    std::uint64_t ticks = 0;
    std::uint64_t missed = 0; ///< number of whole periods in which no tick began
};

/// Monotonic clock, s.
double tick_clock_s() noexcept;

/// Measures ticks. Call begin() and end() around each tick.
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
    void end() noexcept;
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
