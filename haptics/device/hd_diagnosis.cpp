#include "haptics/device/hd_diagnosis.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <cstdlib>
#include <fstream>
#include <iterator>

#include <unistd.h>

namespace retractor::haptics {

namespace {

    namespace fs = std::filesystem;

    constexpr const char* kVendor = "2988"; // USB vendor id of 3D Systems

    std::string first_line(const fs::path& file)
    {
        std::ifstream in(file);
        std::string line;
        std::getline(in, line);
        return line;
    }

    bool mentions(const fs::path& file, const std::string& text)
    {
        std::ifstream in(file);
        const std::string content { std::istreambuf_iterator<char>(in), {} };
        return content.find(text) != std::string::npos;
    }

    std::vector<fs::path> entries_of(const fs::path& folder)
    {
        std::vector<fs::path> entries;
        std::error_code error;
        for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
            entries.push_back(entry->path());
        return entries;
    }

    HdFinding check_library(const std::vector<std::string>& libraries)
    {
        HdFinding finding { .name = "OpenHaptics" };
        try {
            const HdLibrary library(libraries);
            finding.found = library.name() + " loads and has every function";
            return finding;
        } catch (const IoError& error) {
            finding.ok = false;
            finding.found = error.what();
        }
        // A missing dependency of a library that exists tells more than the names that do not exist.
        std::string lacking;
        for (std::size_t at = 0; at < finding.found.size(); ++at) {
            const std::string missing = missing_library(finding.found.substr(at));
            if (missing.starts_with("lib") && missing.find("libHD.so") == std::string::npos
                && missing.find(' ') == std::string::npos && missing.find('/') == std::string::npos) {
                lacking = missing;
                break;
            }
        }
        if (lacking.starts_with("libncurses") || lacking.starts_with("libtinfo"))
            finding.advice = "OpenHaptics needs " + lacking + ": apt install libncurses5 libtinfo5";
        else if (lacking.starts_with("libPhantomIOLib"))
            finding.advice
                = "OpenHaptics needs " + lacking + ": install the Touch Device Driver (TouchDriver) of 3D Systems";
        else if (!lacking.empty())
            finding.advice = "OpenHaptics needs " + lacking + ": install it";
        else
            finding.advice
                = "needed only for 3D Systems Touch devices: install their OpenHaptics and Touch Device Driver";
        return finding;
    }

    HdFinding check_rule(const fs::path& root)
    {
        for (const char* folder : { "etc/udev/rules.d", "lib/udev/rules.d", "usr/lib/udev/rules.d" })
            for (const fs::path& file : entries_of(root / folder))
                if (file.extension() == ".rules" && mentions(file, kVendor))
                    return { .name = "udev rule", .found = file.string() };
        return { .name = "udev rule",
            .ok = false,
            .found = "no rule names USB vendor " + std::string(kVendor),
            .advice = "copy 99-3dsystems.rules of the Touch Device Driver to /etc/udev/rules.d, then: udevadm control "
                      "--reload && udevadm trigger" };
    }

    /// The device file below `root`; empty when no device is plugged in.
    fs::path plugged_in(const fs::path& root, std::string& name)
    {
        for (const fs::path& device : entries_of(root / "sys/bus/usb/devices"))
            if (first_line(device / "idVendor") == kVendor) {
                name = kVendor + (":" + first_line(device / "idProduct"));
                return root / "dev/bus/usb"
                    / formatted("%03d/%03d", std::atoi(first_line(device / "busnum").c_str()),
                        std::atoi(first_line(device / "devnum").c_str()));
            }
        return {};
    }

    HdFinding check_configuration(const fs::path& home)
    {
        HdFinding finding { .name = "configuration" };
        const char* const set = std::getenv("GTDD_HOME");
        const fs::path folder = set != nullptr && *set != '\0' ? fs::path(set) : home / ".3dsystems" / "config";
        std::error_code error;
        finding.ok = fs::is_directory(folder, error);
        finding.found = folder.string() + (finding.ok ? "" : " is not there");
        if (!finding.ok)
            finding.advice = "run the driver's Touch_Setup as the user who will use the device (it names the devices)";
        return finding;
    }

} // namespace

std::vector<HdFinding> diagnose_hd(
    const std::vector<std::string>& libraries, const std::filesystem::path& root, const std::filesystem::path& home)
{
    std::vector<HdFinding> findings { check_library(libraries), check_rule(root) };
    std::string name;
    const fs::path node = plugged_in(root, name);
    if (node.empty()) {
        findings.push_back({ .name = "device",
            .ok = false,
            .found = "no USB device of 3D Systems",
            .advice = "plug it in (and its power supply), then look at dmesg" });
    } else {
        findings.push_back({ .name = "device", .found = name + " at " + node.string() });
        HdFinding permission { .name = "permission", .found = node.string() + " can be written" };
        if (::access(node.c_str(), R_OK | W_OK) != 0) {
            permission.ok = false;
            permission.found = node.string() + " cannot be written";
            permission.advice
                = "the udev rule gives the right to it: plug the device in again after installing the rule; "
                  "never run as root";
        }
        findings.push_back(permission);
    }
    const char* const own = std::getenv("HOME");
    findings.push_back(check_configuration(!home.empty() ? home : fs::path(own != nullptr ? own : "/")));
    return findings;
}

} // namespace retractor::haptics
