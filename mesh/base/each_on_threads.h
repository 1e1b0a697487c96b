#pragma once
// Does independent pieces of work on several threads.

#include "mesh/base/job.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace retractor {

/// Calls f(0) to f(count - 1), each once, on up to `threads` threads, this one among them. No further call begins after
/// the job was cancelled, or after one threw; the first exception is thrown here when all threads have ended.
template <class F> void each_on_threads(std::size_t count, int threads, const Job& job, const F& f)
{
    std::atomic<std::size_t> next { 0 };
    std::exception_ptr failure;
    std::mutex mutex; // of the failure
    const auto work = [&] {
        for (std::size_t i = next.fetch_add(1); i < count && !job.cancelled(); i = next.fetch_add(1)) {
            try {
                f(i);
            } catch (...) {
                const std::scoped_lock lock(mutex);
                if (!failure)
                    failure = std::current_exception();
                next.store(count);
            }
        }
    };
    {
        std::vector<std::jthread> others;
        const auto wanted = std::min<std::size_t>(static_cast<std::size_t>(std::max(threads, 1)), count);
        for (std::size_t t = 1; t < wanted; ++t)
            others.emplace_back(work);
        work();
    }
    if (failure)
        std::rethrow_exception(failure);
}

} // namespace retractor
