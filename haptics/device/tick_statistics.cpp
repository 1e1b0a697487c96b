#include "haptics/device/tick_statistics.h"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace retractor::haptics {

double TickHistogram::edge(std::size_t bin) { return kLow * std::pow(10.0, static_cast<double>(bin) / kPerDecade); }

void TickHistogram::add(double seconds) noexcept
{
    const double place = seconds > kLow ? kPerDecade * std::log10(seconds / kLow) + 1.0 : 0.0;
    ++counts_[static_cast<std::size_t>(std::min(place, static_cast<double>(counts_.size() - 1)))];
    ++count_;
    sum_ += seconds;
    max_ = std::max(max_, seconds);
}

double TickHistogram::mean_s() const noexcept { return count_ == 0 ? 0.0 : sum_ / static_cast<double>(count_); }

double TickHistogram::percentile_s(double share) const noexcept
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

std::vector<TickHistogram::Bin> TickHistogram::bins() const
{
    std::vector<Bin> bins;
    for (std::size_t bin = 0; bin < counts_.size(); ++bin)
        if (counts_[bin] > 0 || !bins.empty())
            bins.push_back({ bin == 0 ? 0.0 : edge(bin - 1), edge(bin), counts_[bin] });
    while (!bins.empty() && bins.back().count == 0)
        bins.pop_back();
    return bins;
}

double tick_clock_s() noexcept
{
    timespec time {};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double TickTimer::begin() noexcept
{
    const double now = clock_();
    double step = period_;
    if (times_.ticks == 0)
        first_ = now;
    else {
        step = now - begun_;
        times_.periods.add(step);
        times_.jitter.add(std::abs(step - period_));
        times_.missed += static_cast<std::uint64_t>(std::max(0.0, std::floor(step / period_ - 0.5)));
    }
    begun_ = now;
    ++times_.ticks;
    return step;
}

void TickTimer::end() noexcept { times_.compute.add(clock_() - begun_); }

} // namespace retractor::haptics
