#pragma once
// The message of an error.

#include "mesh/base/error.h"

#include <functional>
#include <string>

namespace retractor::test_support {

/// The text "where: what" of the error that `f` throws, or "what" where it names no place; empty when `f` throws no
/// Error.
inline std::string message_of(const std::function<void()>& f)
{
    try {
        f();
    } catch (const Error& error) {
        return error.where().empty() ? error.what() : error.where() + ": " + error.what();
    }
    return {};
}

} // namespace retractor::test_support
