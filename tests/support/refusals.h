#pragma once
// Tests that calls with bad input are refused.

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace retractor::test_support {

/// Calls with one bad value each, and the same calls with good values. The good calls show that the bad value is the
/// reason for a refusal.
struct SpoiltCalls {
    std::vector<std::function<void()>> spoilt, sound;
};

/// Expects that every spoilt call throws an Error with a message, and that no sound call throws.
inline void expect_all_refused(const SpoiltCalls& calls)
{
    EXPECT_FALSE(calls.sound.empty()) << "nothing tells whether a sound call is accepted";
    for (std::size_t i = 0; i < calls.sound.size(); ++i)
        EXPECT_NO_THROW(calls.sound[i]()) << "sound call number " << i + 1;
    for (std::size_t i = 0; i < calls.spoilt.size(); ++i)
        try {
            calls.spoilt[i]();
            ADD_FAILURE() << "spoilt call number " << i + 1 << " of " << calls.spoilt.size() << " was accepted";
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()), "") << "spoilt call number " << i + 1;
        }
}

} // namespace retractor::test_support
