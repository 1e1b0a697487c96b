#pragma once
<<<<<<< HEAD
// How often this program has asked for memory: what shows that a tick does not.

#include <cstddef>

namespace retractor::testing {

/// By this thread, since it started.
std::size_t allocation_count() noexcept;

} // namespace retractor::testing
=======
// How often this thread has asked for memory: the test program's malloc counts.

#include <cstddef>

namespace retractor {

/// False under sanitizers, which bring their own malloc.
bool allocations_are_counted() noexcept;
/// Of this thread, since it began.
std::size_t allocation_count() noexcept;

} // namespace retractor
>>>>>>> fd3ed8f (Add the servo: coupling within the device's limits, passivity observer, fault latch, tick thread and histograms)
