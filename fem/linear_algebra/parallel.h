#pragma once
// How the solver uses a second core, with the same result on any number of them; and whether it may, for all solvers.

#include <cstddef>
#include <thread>
#include <utility>

namespace retractor::fem {

/// How many threads one solve may use: 1, or 2 and more, which are all the same, as the work is split in two halves at
/// most. One setting for the whole process; to begin with, as many as there are cores.
void set_solver_threads(int threads);
bool solver_has_second_thread();

/// Runs `work` on a second thread, which is waited for at the end of this one's life; where there is no second thread,
/// at once. The work must not throw.
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

/// Runs f(half, begin, end) on the two halves of a range at once where there are two cores. The halves do not depend on
/// the machine.
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
