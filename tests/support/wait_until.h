#pragma once
// Waits in tests for an event of another thread, not for a fixed time, which a busy machine may exceed.

#include <chrono>
#include <thread>

namespace retractor::test_support {

/// Waits until `condition()` is true. @return whether it became true within two minutes, the limit for a busy machine
template <class Condition> [[nodiscard]] bool wait_until(const Condition& condition)
{
    constexpr std::chrono::seconds kPatience { 120 };
    constexpr std::chrono::milliseconds kPause { 1 };
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!condition()) {
        if (std::chrono::steady_clock::now() > end)
            return false;
        std::this_thread::sleep_for(kPause);
    }
    return true;
}

} // namespace retractor::test_support
