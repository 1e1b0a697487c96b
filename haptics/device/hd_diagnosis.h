#pragma once
// Finds out why a Touch does not work on this machine: the HDAPI library, its dependencies, the udev rule, and
// permissions.

#include "haptics/device/hd_library.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::haptics {

struct HdFinding {
    std::string name; ///< "OpenHaptics", "udev rule", "device", "permission", "configuration"
    bool ok = true;
    std::string found = {};
    std::string advice = {}; ///< what the user should do; empty when everything is right
};

/// Tries to load the library, and checks where Linux keeps rules and devices. Opens no device.
/// @param root root of the checked file system
/// @param home the user's folder
std::vector<HdFinding> diagnose_hd(const std::vector<std::string>& libraries = default_hd_libraries(),
    const std::filesystem::path& root = "/", const std::filesystem::path& home = {});

} // namespace retractor::haptics
