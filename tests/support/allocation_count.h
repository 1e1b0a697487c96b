#pragma once
// Counts the allocations of a thread by a malloc of the test program. The count shows that a tick does not allocate.

#include <cstddef>

namespace retractor::test_support {

/// False under sanitizers, which bring their own malloc.
bool allocations_are_counted() noexcept;
/// Number of allocations of this thread since its start; 0 when allocations are not counted.
std::size_t allocation_count() noexcept;

} // namespace retractor::test_support
