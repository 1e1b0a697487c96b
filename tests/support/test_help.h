#pragma once
// Shared by the tests of haptics: the message of an error.

#include "mesh/base/error.h"

#include <functional>
#include <string>

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

} // namespace retractor::test_support
