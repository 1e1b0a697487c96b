#pragma once
// Use of a second core by the solvers, with the same result on any number of cores, and the setting that allows it.

#include <cstddef>
#include <thread>
#include <utility>

namespace retractor::fem {

/// Sets the number of threads that one solve may use: 1, or 2 and more. All numbers from 2 have the same effect, since
/// work is split into two halves at most. The setting is for the whole process; its initial value is the number of
/// cores.
void set_solver_threads(int threads);
bool solver_has_second_thread();

/// Runs `work` on a second thread. The destructor waits for the thread. Where no second thread is allowed, the
/// constructor runs `work` itself.
/// @pre `work` throws nothing
class ScopedThread {
public:
    template <class F> explicit ScopedThread(F&& work)
    {
        if (solver_has_second_thread())
            thread_ = std::jthread(std::forward<F>(work));
        else
            work();
    }

private:
    std::jthread thread_;
};

/// Runs f(half, begin, end) on the two halves of a range, at the same time where two threads are allowed. The halves do
/// not depend on the machine.
template <class F> void parallel_halves(std::size_t count, const F& f)
{
    const std::size_t middle = count / 2;
    constexpr std::size_t kWorthAThread = 2000; // elements; starting a thread takes as long as about a hundred
    if (count < kWorthAThread) {
        f(std::size_t { 0 }, std::size_t { 0 }, middle);
        f(std::size_t { 1 }, middle, count);
        return;
    }
    const ScopedThread second([&] { f(std::size_t { 1 }, middle, count); });
    f(std::size_t { 0 }, std::size_t { 0 }, middle);
}

} // namespace retractor::fem
