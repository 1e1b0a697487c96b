#pragma once
// How often this thread has asked for memory, counted by the test program's own malloc: what shows that a tick does
// not.

#include <cstddef>

namespace retractor::test_support {

/// False under sanitizers, which bring their own malloc.
bool allocations_are_counted() noexcept;
/// By this thread, since it started; 0 when they are not counted.
std::size_t allocation_count() noexcept;

} // namespace retractor::test_support
