#pragma once
// Stopwatches of processor time: the cost of work without the influence of other programs on the machine.

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

/// Processor time of the thread that makes and reads the watch.
using CpuWatch = ProcessorWatch<CLOCK_THREAD_CPUTIME_ID>;
/// Processor time of all threads of the process.
using ProcessCpuWatch = ProcessorWatch<CLOCK_PROCESS_CPUTIME_ID>;

} // namespace retractor::benchmarks
