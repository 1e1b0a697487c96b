#pragma once
// A limit on the time of a part of a job. The part runs with a job of its own, which is cancelled when the time is up
// or when the whole job is cancelled. Times in seconds of the wall clock.

#include "mesh/base/job.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace retractor {

class TimeLimit {
public:
    /// Starts the clock.
    /// @param job the whole job; outlives this object
    /// @param seconds not negative; 0: the time is up at once
    TimeLimit(const Job& job, double seconds);
    TimeLimit(const TimeLimit&) = delete;
    TimeLimit& operator=(const TimeLimit&) = delete;
    ~TimeLimit() = default; ///< stops the clock

    /// Gives the part this much time from now on. A part whose time is up stays cancelled.
    /// @param seconds not negative
    void restart(double seconds);
    /// The job of the part. It reports and records as the whole job does.
    const Job& job() const { return part_; }
    /// Whether the part was cancelled because its time was up, and not with the whole job.
    bool is_over() const { return over_.load(std::memory_order_relaxed); }

private:
    std::atomic<bool> cancel_ { false }, over_ { false };
    Job part_;
    std::mutex mutex_;
    std::chrono::steady_clock::time_point end_; ///< under mutex_
    std::condition_variable_any stopped_;
    std::jthread clock_; ///< last: the thread uses the members above
};

} // namespace retractor
