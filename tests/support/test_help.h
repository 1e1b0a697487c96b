#pragma once
// Shared by the tests of haptics: the message of an error and a temporary folder.

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

/// A new empty folder, which the destructor removes with its contents.
struct TemporaryFolder {
    std::filesystem::path path = std::filesystem::temp_directory_path()
        / ("retractor-haptics-" + std::to_string(::getpid()) + "-" + std::to_string(++count));
    TemporaryFolder() { std::filesystem::create_directories(path); }
    ~TemporaryFolder() { std::filesystem::remove_all(path); }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

private:
    static inline int count = 0;
};

} // namespace retractor::test_support
