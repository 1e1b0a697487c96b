#include "datasets/dicom/dicom_identity.h"

#include "datasets/dicom/dicom.h"
#include "mesh/base/error.h"
#include "tests/datasets/dicom/dicom_bytes.h"
#include "tests/support/temporary_folder.h"

namespace retractor::datasets {
namespace dicom_identity_test {

    TEST(DicomIdentity, AFileNestedTooDeepHasNone)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 2);
        std::string nested;
        constexpr int kLevels = 200000; // more than any stack holds
        for (int n = 0; n < kLevels; ++n)
            nested += test_support::DicomBytes::number(0x0040, 2) + test_support::DicomBytes::number(0xA730, 2)
                + std::string("SQ\0\0", 4) + test_support::DicomBytes::number(0xFFFFFFFF, 4)
                + test_support::DicomBytes::number(0xFFFE, 2) + test_support::DicomBytes::number(0xE000, 2)
                + test_support::DicomBytes::number(0xFFFFFFFF, 4);
        test_support::write_bytes(
            folder / "ct/deep.dcm", test_support::dicom_file(test_support::DicomBytes()) + nested);
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

    TEST(DicomIdentity, WholeWordsAreWithheldWhateverTheirCase)
    {
        const std::vector<PatientIdentity> patients { { "Long^Ada Q", "A-17" } };
        EXPECT_EQ(without_identity("LONG, ada: along the aorta, id a-17, A-170", patients),
            "[withheld], [withheld]: along the aorta, id [withheld], A-170");
        EXPECT_EQ(without_identity(
                      "M\u00DCLLER \u2013\u017Daneta\u2013 m\u00FCllerin", { { "M\u00FCller^\u017Eaneta", "" } }),
            "[withheld] \u2013[withheld]\u2013 m\u00FCllerin");
    }

    TEST(DicomIdentity, TwoShortWordsAreANameAndOneIsNone)
    {
        EXPECT_EQ(without_identity("thorax NG_li, 5 mm", { { "Ng^Li", "" } }), "thorax [withheld]_[withheld], 5 mm");
        EXPECT_EQ(without_identity("5 mm, li", { { "mm^Q", "" } }), "5 mm, li");
        EXPECT_EQ(without_identity("5 mm, Q", { { "mm^Q", "" } }), "5 [withheld], [withheld]");
        EXPECT_EQ(without_identity("Li Li", { { "Li^Li", "" } }), "Li Li"); // one word, said twice
    }

    TEST(DicomIdentity, SeriesDescriptionsOfShortOrAccentedNamesAreDropped)
    {
        const test_support::TemporaryFolder folder;
        const auto description = [&](const std::string& name, const std::string& text) {
            const auto change = [&](test_support::DicomBytes& slice, int) {
                slice.text(0x00080005, "CS", "ISO_IR 192").text(0x00100010, "PN", name).text(0x0008103E, "LO", text);
            };
            std::filesystem::remove_all(folder / "ct");
            test_support::write_stack(folder / "ct", 2, change);
            return list_dicom_series(folder / "ct").front().description;
        };
        EXPECT_EQ(description("Ng^Li", "Thorax Ng Li"), "");
        EXPECT_EQ(description("Ng^Li", "Thorax li. Lunge"), "Thorax li. Lunge");
        EXPECT_EQ(description("\u00D6zg\u00FCr^Q", "CT \u00F6ZG\u00DCR"), "");
        EXPECT_EQ(description("\u00D6zg\u00FCr^Q", "CT thorax"), "CT thorax");
    }

} // namespace dicom_identity_test
} // namespace retractor::datasets
