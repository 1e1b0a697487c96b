#pragma once
// Finds HDAPI and loads it at run time.

#include "haptics/device/hdapi.h"

#include <string>
#include <vector>

namespace retractor::haptics {

/// Names in the order of the attempts. The environment variable RETRACTOR_HD_LIBRARY replaces the list by one name.
std::vector<std::string> default_hd_libraries();

/// A name that could not be loaded. The reason is the dynamic linker's message, which names a missing dependency.
struct HdAttempt {
    std::string name, reason;
};

/// Keeps the library loaded for the object's lifetime.
class HdLibrary {
public:
    /// Loads the first of `names` that has every function.
    /// @throws IoError with all attempts and their reasons
    explicit HdLibrary(const std::vector<std::string>& names = default_hd_libraries());
    ~HdLibrary();
    HdLibrary(const HdLibrary&) = delete;
    HdLibrary& operator=(const HdLibrary&) = delete;

    [[nodiscard]] const hd::Functions& functions() const noexcept { return functions_; }
    [[nodiscard]] const std::string& name() const noexcept { return name_; }
    /// Failed attempts before the loaded library.
    [[nodiscard]] const std::vector<HdAttempt>& attempts() const noexcept { return attempts_; }

private:
    std::string load(const std::string& name);

    void* library_ = nullptr;
    hd::Functions functions_ {};
    std::string name_;
    std::vector<HdAttempt> attempts_;
};

/// The library that the linker's message reports as missing ("libncurses.so.5"); empty when the message has another
/// reason.
std::string missing_library(const std::string& reason);

} // namespace retractor::haptics
