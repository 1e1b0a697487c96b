#include "datasets/dicom/dicom_nesting.h"

#include "tests/datasets/dicom/dicom_bytes.h"
#include "tests/support/temporary_folder.h"

namespace retractor::datasets {
namespace dicom_nesting_test {

    constexpr std::uint32_t kUndefined = 0xFFFFFFFF;
    constexpr int kMany = 5000; // levels; the parser's stack ends at some ten thousand
    constexpr int kLimit = 64;

    std::string word(std::uint32_t value, int size, bool big)
    {
        std::string bytes = test_support::DicomBytes::number(value, size);
        if (big)
            std::reverse(bytes.begin(), bytes.end());
        return bytes;
    }
    std::string tag(std::uint32_t value, bool big = false)
    {
        return word(value >> 16, 2, big) + word(value & 0xFFFF, 2, big);
    }
    std::string delimiter(std::uint32_t value, std::uint32_t length, bool big = false)
    {
        return tag(value, big) + word(length, 4, big);
    }
    std::string opened(bool big = false)
    {
        return tag(0x0040A730, big) + std::string("SQ\0\0", 4) + word(kUndefined, 4, big)
            + delimiter(0xFFFEE000, kUndefined, big);
    }
    std::string closed() { return delimiter(0xFFFEE00D, 0) + delimiter(0xFFFEE0DD, 0); }
    std::string value(const std::string& bytes)
    {
        return tag(0x00420011) + std::string("OB\0\0", 4)
            + test_support::DicomBytes::number(static_cast<std::int64_t>(bytes.size()), 4) + bytes;
    }
    std::string repeated(const std::string& text, int times)
    {
        std::string all;
        for (int n = 0; n < times; ++n)
            all += text;
        return all;
    }
    int nesting(const std::string& data_set, const std::string& syntax = "1.2.840.10008.1.2.1")
    {
        const test_support::TemporaryFolder folder;
        test_support::write_bytes(folder / "file",
            test_support::dicom_file(test_support::DicomBytes(), test_support::kCtStorage, syntax) + data_set);
        return dicom_nesting(folder / "file", kLimit);
    }

    TEST(DicomNesting, CountsLevelsNotItems)
    {
        const std::string shallow = repeated(opened() + value("ab") + closed(), 500);
        EXPECT_EQ(nesting(""), 0);
        EXPECT_EQ(nesting(shallow), 1);
        EXPECT_EQ(nesting(opened() + opened() + closed() + closed() + shallow), 2);
        EXPECT_EQ(nesting(repeated(opened(), kMany)), kLimit);
        const test_support::TemporaryFolder folder;
        const std::vector<double> heights(200, 1.0);
        test_support::write_bytes(folder / "enhanced",
            test_support::dicom_file(
                test_support::enhanced_ct(heights, std::vector<double>(200, 1.0)), test_support::kEnhancedCtStorage));
        EXPECT_EQ(dicom_nesting(folder / "enhanced", kLimit), 2);
    }

    TEST(DicomNesting, ImplicitSequencesAreFound)
    {
        const std::string implicit
            = tag(0x0040A730) + test_support::DicomBytes::number(kUndefined, 4) + delimiter(0xFFFEE000, kUndefined);
        EXPECT_EQ(nesting(repeated(implicit, 3) + repeated(closed(), 3), "1.2.840.10008.1.2"), 3);
        EXPECT_EQ(nesting(repeated(implicit, kMany), "1.2.840.10008.1.2"), kLimit);
        const std::string unknown = tag(0x0040A730) + std::string("UN\0\0", 4)
            + test_support::DicomBytes::number(kUndefined, 4) + delimiter(0xFFFEE000, kUndefined);
        EXPECT_EQ(nesting(unknown + repeated(implicit, kMany)), kLimit);
    }

    TEST(DicomNesting, IsNotPassedByFakes)
    {
        EXPECT_EQ(nesting(repeated(opened(true), kMany), "1.2.840.10008.1.2.2"), kLimit);
        // Ends of items inside a value end nothing.
        EXPECT_EQ(nesting(repeated(opened() + value(closed()), kMany)), kLimit);
        // Nor do the pixels' tag and a byte too many hide what comes next.
        EXPECT_EQ(nesting(value(tag(0x7FE00010)) + value("odd") + repeated(opened(), kMany)), kLimit);
        // Items that end before what they hold.
        const std::string sequence
            = tag(0x0040A730) + std::string("SQ\0\0", 4) + test_support::DicomBytes::number(kUndefined, 4);
        EXPECT_EQ(nesting(repeated(sequence + delimiter(0xFFFEE000, 8), kMany)), kLimit);
        // After the pixels, too, the parser goes on, and into items of undefined length in their place.
        EXPECT_EQ(nesting(tag(0x7FE00010) + std::string("OW\0\0", 4) + test_support::DicomBytes::number(2, 4) + "ab"
                      + repeated(opened(), kMany)),
            kLimit);
        EXPECT_EQ(nesting(tag(0x7FE00010) + std::string("OB\0\0", 4) + test_support::DicomBytes::number(kUndefined, 4)
                      + repeated(delimiter(0xFFFEE000, kUndefined), kMany)),
            kLimit);
    }

    TEST(DicomNesting, FragmentsAndDamageAreNoDepth)
    {
        const std::string pixels = tag(0x7FE00010) + std::string("OB\0\0", 4)
            + test_support::DicomBytes::number(kUndefined, 4) + repeated(delimiter(0xFFFEE000, 2) + "ab", 300);
        EXPECT_EQ(nesting(pixels + delimiter(0xFFFEE0DD, 0)), 0);
        EXPECT_EQ(nesting(pixels + delimiter(0xFFFEE0DD, 0) + std::string(64, '\0')), 0); // padded
        EXPECT_EQ(nesting(pixels), 0); // cut short
    }

} // namespace dicom_nesting_test
} // namespace retractor::datasets
