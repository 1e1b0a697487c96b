#pragma once
// How regular a servo is: histograms of periods and of compute times that are filled inside the tick.

#include <array>
#include <cstdint>
#include <vector>

namespace retractor::haptics {

/// Counts of durations in bins that grow by a twentieth of a decade's factor, 12 %, from 100 ns to 10 s. Allocates
/// nothing; reading it is for when nothing is added.
class TickHistogram {
public:
    struct Bin {
        double low_s, high_s;
        std::uint64_t count;
    };

    void add(double seconds) noexcept;
    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
    /// Exact; 0 when empty.
    [[nodiscard]] double mean_s() const noexcept;
    [[nodiscard]] double max_s() const noexcept { return max_; }
    /// The upper end of the bin that holds this share of the counts, at most the largest value: never flattering.
    [[nodiscard]] double percentile_s(double share) const noexcept;
    /// From the first to the last that is not empty.
    [[nodiscard]] std::vector<Bin> bins() const;

private:
    static constexpr double kLow = 1e-7;
    static constexpr int kPerDecade = 20, kDecades = 8;
    static double edge(std::size_t bin);

    std::array<std::uint64_t, kPerDecade * kDecades + 2> counts_ {}; ///< the first is for less, the last for more
    std::uint64_t count_ = 0;
    double sum_ = 0.0, max_ = 0.0;
};

/// What a tick source measures of itself.
struct TickTimes {
    TickHistogram periods; ///< from tick to tick
    TickHistogram jitter; ///< how far a period is from the nominal one, either way
    TickHistogram compute; ///< in the tick, by the wall clock: what other programs took is in it
    std::uint64_t ticks = 0;
    std::uint64_t missed = 0; ///< whole periods in which no tick began
};

/// Monotonic clock, s.
double tick_clock_s() noexcept;

/// Runs begin() and end() around each tick.
class TickTimer {
public:
    using Clock = double (*)() noexcept;
    explicit TickTimer(double period_s, Clock clock = tick_clock_s)
        : period_(period_s)
        , clock_(clock)
    {
    }
    /// @return seconds since the tick before; the nominal period at the first
    double begin() noexcept;
    void end() noexcept;
    /// Of this tick since the first.
    [[nodiscard]] double time_s() const noexcept { return begun_ - first_; }
    [[nodiscard]] const TickTimes& times() const noexcept { return times_; }

private:
    double period_;
    Clock clock_;
    double first_ = 0.0, begun_ = 0.0;
    TickTimes times_;
};

} // namespace retractor::haptics
