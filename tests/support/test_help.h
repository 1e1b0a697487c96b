#pragma once
// Shared by tests: the message of an error, and waiting for another thread.

#include "mesh/base/error.h"

#include <chrono>
#include <functional>
#include <string>
#include <thread>

namespace retractor::test_support {

/// The text "what [where]" of the error that `f` throws; empty when `f` throws no Error.
inline std::string message_of(const std::function<void()>& f)
{
    try {
        f();
    } catch (const Error& error) {
        return std::string(error.what()) + " [" + error.where() + "]";
    }
    return {};
}

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
