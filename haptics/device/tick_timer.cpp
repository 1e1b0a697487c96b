#include "haptics/device/tick_timer.h"

#include <algorithm>
#include <cmath>
#include <ctime>

namespace retractor::haptics {

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
        times_.missed += static_cast<std::uint64_t>(std::max(0.0, std::floor(step / period_ - 0.5)));
    }
    begun_ = now;
    ++times_.ticks;
    return step;
}

} // namespace retractor::haptics
