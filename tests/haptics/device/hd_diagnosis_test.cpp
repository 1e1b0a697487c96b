#include "haptics/device/hd_diagnosis.h"

#include "tests/support/temporary_folder.h"

#include <gtest/gtest.h>

#include <fstream>

namespace retractor::haptics {
namespace hd_diagnosis_test {

    namespace fs = std::filesystem;

    void put(const fs::path& file, const std::string& text)
    {
        fs::create_directories(file.parent_path());
        std::ofstream(file) << text;
    }

    TEST(HdDiagnosis, SaysWhatIsMissingOnAMachineWithoutAnything)
    {
        const test_support::TemporaryFolder root;
        const auto findings = diagnose_hd({ "libNoSuchHD.so" }, root.path, root.path / "home");
        ASSERT_EQ(findings.size(), 4u);
        for (const HdFinding& finding : findings) {
            EXPECT_FALSE(finding.ok) << finding.name;
            EXPECT_NE(finding.advice, "") << finding.name;
        }
        EXPECT_EQ(findings[0].name, "OpenHaptics");
        EXPECT_EQ(findings[1].found, "no rule names USB vendor 2988");
        EXPECT_EQ(findings[2].found, "no USB device of 3D Systems");
    }

    TEST(HdDiagnosis, IsContentWithAMachineThatHasAll)
    {
        const test_support::TemporaryFolder root;
        put(root.path / "etc/udev/rules.d/99-3dsystems.rules", "ATTRS{idVendor}==\"2988\", MODE=\"0666\"\n");
        const fs::path usb = root.path / "sys/bus/usb/devices/1-2";
        put(usb / "idVendor", "2988\n");
        put(usb / "idProduct", "0304\n");
        put(usb / "busnum", "1\n");
        put(usb / "devnum", "7\n");
        put(root.path / "dev/bus/usb/001/007", "");
        fs::create_directories(root.path / "home/.3dsystems/config");
        const auto findings = diagnose_hd({ RETRACTOR_SIMULATED_HD }, root.path, root.path / "home");
        ASSERT_EQ(findings.size(), 5u);
        for (const HdFinding& finding : findings) {
            EXPECT_TRUE(finding.ok) << finding.name << ": " << finding.found;
            EXPECT_EQ(finding.advice, "") << finding.name;
        }
        EXPECT_EQ(findings[2].found, "2988:0304 at " + (root.path / "dev/bus/usb/001/007").string());
        fs::remove(root.path / "dev/bus/usb/001/007");
        const auto without = diagnose_hd({ RETRACTOR_SIMULATED_HD }, root.path, root.path / "home");
        EXPECT_EQ(without[3].name, "permission");
        EXPECT_FALSE(without[3].ok);
        EXPECT_NE(without[3].advice.find("udev rule"), std::string::npos);
    }

    TEST(HdDiagnosis, NamesALibraryThatTheLibraryNeedsItself)
    {
        // A library whose own dependency is not there.
        const auto findings = diagnose_hd({ RETRACTOR_BROKEN_HD }, "/", "/");
        EXPECT_FALSE(findings[0].ok);
        EXPECT_EQ(findings[0].advice,
            "OpenHaptics needs libPhantomIOLib42.so: install the Touch Device Driver "
            "(TouchDriver) of 3D Systems");
    }

} // namespace hd_diagnosis_test
} // namespace retractor::haptics
