#include "datasets/dicom_identity.h"

#include "dicom_bytes.h"
#include "mesh/base/error.h"
#include "temporary_folder.h"

namespace retractor {
namespace {

    TEST(DicomIdentity, AFileNestedTooDeepHasNone)
    {
        const TemporaryFolder folder;
        write_stack(folder / "ct", 2);
        std::string nested;
        constexpr int kLevels = 200000; // more than any stack holds
        for (int n = 0; n < kLevels; ++n)
            nested += DicomBytes::number(0x0040, 2) + DicomBytes::number(0xA730, 2) + std::string("SQ\0\0", 4)
                + DicomBytes::number(0xFFFFFFFF, 4) + DicomBytes::number(0xFFFE, 2) + DicomBytes::number(0xE000, 2)
                + DicomBytes::number(0xFFFFFFFF, 4);
        write_bytes(folder / "ct/deep.dcm", dicom_file(DicomBytes()) + nested);
        const std::vector<PatientIdentity> found = dicom_identities(folder / "ct");
        ASSERT_EQ(found.size(), 1u);
        EXPECT_EQ(found.front().name, "Secret^Person");
        try {
            read_dicom_identity(folder / "ct");
            ADD_FAILURE() << "not refused";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("nested too deep"), std::string::npos);
        }
    }

} // namespace
} // namespace retractor
