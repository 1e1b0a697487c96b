#pragma once
// How often this program has asked for memory: what shows that a tick does not.

#include <cstddef>

namespace retractor::testing {

/// By this thread, since it started.
std::size_t allocation_count() noexcept;

} // namespace retractor::testing
