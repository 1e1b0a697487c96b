#pragma once
// What several tests of the haptics floor share.

#include "mesh/base/error.h"

#include <functional>
#include <string>

namespace retractor::test_support {

/// "what [where]" of the error that `f` throws; empty when it throws none.
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
