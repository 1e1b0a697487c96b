#pragma once
// Regularity of a servo: histograms of periods and of compute times, filled inside the tick. Units s.

#include "haptics/device/device.h"
#include "haptics/device/tick_timer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace retractor::test_support {

/// Counts of durations in bins from 100 ns to 10 s. There are twenty bins a decade, so a bin is 12 % wider than the one
/// before. Allocates nothing.
/// @pre the reading functions run only when nothing is added
class TickHistogram {
public:
    struct Bin {
        double low_s, high_s;
        std::uint64_t count;
    };

    void add(double seconds) noexcept
    {
        const double place = seconds > kLow ? kPerDecade * std::log10(seconds / kLow) + 1.0 : 0.0;
        ++counts_[static_cast<std::size_t>(std::min(place, static_cast<double>(counts_.size() - 1)))];
        ++count_;
        sum_ += seconds;
        max_ = std::max(max_, seconds);
    }
    [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
    /// Exact mean; 0 when empty.
    [[nodiscard]] double mean_s() const noexcept { return count_ == 0 ? 0.0 : sum_ / static_cast<double>(count_); }
    [[nodiscard]] double max_s() const noexcept { return max_; }
    /// Upper end of the bin that contains this share of the counts, limited to the largest value. Never too small.
    [[nodiscard]] double percentile_s(double share) const noexcept
    {
        const double wanted = share * static_cast<double>(count_);
        std::uint64_t seen = 0;
        for (std::size_t bin = 0; bin + 1 < counts_.size(); ++bin) {
            seen += counts_[bin];
            if (seen > 0 && static_cast<double>(seen) >= wanted)
                return std::min(edge(bin), max_);
        }
        return max_;
    }
    /// All bins from the first to the last that is not empty.
    [[nodiscard]] std::vector<Bin> bins() const
    {
        std::vector<Bin> bins;
        for (std::size_t bin = 0; bin < counts_.size(); ++bin)
            if (counts_[bin] > 0 || !bins.empty())
                bins.push_back({ bin == 0 ? 0.0 : edge(bin - 1), edge(bin), counts_[bin] });
        while (!bins.empty() && bins.back().count == 0)
            bins.pop_back();
        return bins;
    }

private:
    static constexpr double kLow = 1e-7;
    static constexpr int kPerDecade = 20, kDecades = 8;
    static double edge(std::size_t bin) { return kLow * std::pow(10.0, static_cast<double>(bin) / kPerDecade); }

    /// The first counts shorter durations, the last longer ones.
    std::array<std::uint64_t, kPerDecade * kDecades + 2> counts_ {};
    std::uint64_t count_ = 0;
    double sum_ = 0.0, max_ = 0.0;
};

/// Measures the ticks of another Ticked.
class MeasuredTicks : public haptics::Ticked {
public:
    explicit MeasuredTicks(haptics::Ticked& inner)
        : inner_(inner)
    {
    }
    void tick(double time_s, double step_s) noexcept override
    {
        constexpr double kPeriod = 1e-3;
        const double begun = haptics::tick_clock_s();
        if (started_) {
            periods.add(step_s);
            jitter.add(std::abs(step_s - kPeriod));
        }
        started_ = true;
        inner_.tick(time_s, step_s);
        compute.add(haptics::tick_clock_s() - begun);
    }

    TickHistogram periods; ///< time from tick to tick
    TickHistogram jitter; ///< absolute difference between a period and the nominal period of 1 ms
    TickHistogram compute; ///< wall-clock time of a tick, including time that other programs took

private:
    haptics::Ticked& inner_;
    bool started_ = false;
};

} // namespace retractor::test_support
