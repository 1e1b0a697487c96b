#pragma once
// Why a Touch does not work on this machine: library, the libraries it needs in turn, udev rule, permission.

#include "haptics/device/hd_library.h"

#include <filesystem>
#include <string>
#include <vector>

namespace retractor::haptics {

struct HdFinding {
    std::string name; ///< "OpenHaptics", "udev rule", "device", "permission", "configuration"
    bool ok = true;
    std::string found = {};
    std::string advice = {}; ///< what to do; empty when nothing needs doing
};

/// Tries the library, and looks where Linux keeps rules and devices. Opens no device.
/// @param root of the file system that is looked at
/// @param home the user's folder
std::vector<HdFinding> diagnose_hd(const std::vector<std::string>& libraries = default_hd_libraries(),
    const std::filesystem::path& root = "/", const std::filesystem::path& home = {});

} // namespace retractor::haptics
