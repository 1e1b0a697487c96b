#pragma once
// Processor time, beside mesh/base/job.h's Stopwatch: what a piece of work costs, whatever else the machine does.

#include <ctime>

namespace retractor::cli {

/// Of the thread that made it and asks it.
class CpuWatch {
public:
    double milliseconds() const { return 1e3 * (now() - start_); }

private:
    static double now()
    {
        timespec time {};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    }
    double start_ = now();
};

} // namespace retractor::cli
