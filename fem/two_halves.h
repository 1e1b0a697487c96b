#pragma once
// How elements are summed on two cores with the same result on any number of them.

#include <cstddef>
#include <thread>

namespace retractor {

/// Runs f(half, begin, end) on the two halves of a range at once where there are two cores. The halves do not depend on
/// the machine.
template <class F> void in_two_halves(std::size_t count, const F& f)
{
    const std::size_t middle = count / 2;
    constexpr std::size_t kWorthAThread = 2000; // elements; starting a thread takes as long as about a hundred
    if (count < kWorthAThread || std::thread::hardware_concurrency() < 2) {
        f(std::size_t { 0 }, std::size_t { 0 }, middle);
        f(std::size_t { 1 }, middle, count);
        return;
    }
    std::thread second([&] { f(std::size_t { 1 }, middle, count); });
    f(std::size_t { 0 }, std::size_t { 0 }, middle);
    second.join();
}

} // namespace retractor
