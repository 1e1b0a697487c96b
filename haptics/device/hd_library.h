#pragma once
// HDAPI found and loaded at run time.

#include "haptics/device/hdapi.h"

#include <string>
#include <vector>

namespace retractor::haptics {

/// In the order in which they are tried; RETRACTOR_HD_LIBRARY in the environment names the only one.
std::vector<std::string> default_hd_libraries();

/// Why one name could not be loaded: the dynamic linker's own words name a library that it needs in turn.
struct HdAttempt {
    std::string name, reason;
};

/// Keeps the library loaded for as long as it lives.
class HdLibrary {
public:
    /// The first of `names` that loads and has every function.
    /// @throws IoError with what was tried and why it failed
    explicit HdLibrary(const std::vector<std::string>& names = default_hd_libraries());
    ~HdLibrary();
    HdLibrary(const HdLibrary&) = delete;
    HdLibrary& operator=(const HdLibrary&) = delete;

    [[nodiscard]] const hd::Functions& functions() const noexcept { return functions_; }
    [[nodiscard]] const std::string& name() const noexcept { return name_; }
    /// Those before it.
    [[nodiscard]] const std::vector<HdAttempt>& attempts() const noexcept { return attempts_; }

private:
    std::string load(const std::string& name);

    void* library_ = nullptr;
    hd::Functions functions_ {};
    std::string name_;
    std::vector<HdAttempt> attempts_;
};

/// The library that the linker's message says is missing ("libncurses.so.5"); empty when it says no such thing.
std::string missing_library(const std::string& reason);

} // namespace retractor::haptics
