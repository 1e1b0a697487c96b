#pragma once
// Processor time, beside mesh/base/job.h's Stopwatch: what a piece of work costs, whatever else the machine does.

#include <ctime>

namespace retractor::benchmarks {

template <clockid_t Clock> class ProcessorWatch {
public:
    double milliseconds() const { return 1e3 * (now() - start_); }

private:
    static double now()
    {
        timespec time {};
        clock_gettime(Clock, &time);
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    }
    double start_ = now();
};

/// Of the thread that made it and asks it.
using CpuWatch = ProcessorWatch<CLOCK_THREAD_CPUTIME_ID>;
/// Of all threads.
using ProcessCpuWatch = ProcessorWatch<CLOCK_PROCESS_CPUTIME_ID>;

} // namespace retractor::benchmarks
