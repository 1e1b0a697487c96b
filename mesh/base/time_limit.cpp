#include "mesh/base/time_limit.h"

#include "mesh/base/assert.h"

#include <algorithm>
#include <chrono>
#include <stop_token>

namespace retractor {

namespace {

    using Clock = std::chrono::steady_clock;

} // namespace

TimeLimit::TimeLimit(const Job& job, double seconds)
    : part_(job)
{
    part_.cancel = &cancel_;
    restart(seconds);
    clock_ = std::jthread([this, &job](const std::stop_token& stop) {
        constexpr std::chrono::milliseconds kLook { 20 }; // how late a cancelled job is noticed
        std::unique_lock lock(mutex_);
        while (!stop.stop_requested() && !job.cancelled()) {
            const auto now = Clock::now();
            if (now >= end_) {
                over_ = true;
                break;
            }
            stopped_.wait_until(lock, stop, std::min<Clock::time_point>(now + kLook, end_), [] { return false; });
        }
        if (!stop.stop_requested())
            cancel_ = true;
    });
}

void TimeLimit::restart(double seconds)
{
    RETRACTOR_ASSERT(seconds >= 0.0);
    const std::scoped_lock lock(mutex_);
    end_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

} // namespace retractor
