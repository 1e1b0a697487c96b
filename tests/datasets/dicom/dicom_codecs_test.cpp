#include "datasets/dicom/dicom_codecs.h"

#include "datasets/dicom/dicom.h"
#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"
#include "tests/datasets/dicom/dicom_bytes.h"
#include "tests/support/temporary_folder.h"

namespace retractor::datasets {
namespace dicom_codecs_test {

    namespace fs = std::filesystem;

    constexpr const char* kRleSyntax = "1.2.840.10008.1.2.5";
    constexpr const char* kJpegLosslessSyntax = "1.2.840.10008.1.2.4.70";

    /// Run-length code of DICOM (PS3.5 annex G) with literal runs only: high bytes, then low bytes.
    std::string rle(const std::vector<int>& stored)
    {
        std::string header = test_support::DicomBytes::number(2, 4);
        std::string body;
        for (const int shift : { 8, 0 }) {
            header += test_support::DicomBytes::number(static_cast<std::int64_t>(64 + body.size()), 4);
            constexpr std::size_t kRun = 100;
            for (std::size_t p = 0; p < stored.size(); p += kRun) {
                const std::size_t count = std::min(kRun, stored.size() - p);
                body += static_cast<char>(count - 1);
                for (std::size_t q = p; q < p + count; ++q)
                    body += static_cast<char>((stored[q] >> shift) & 0xFF);
            }
            if (body.size() % 2 != 0)
                body += '\0';
        }
        header.resize(64, '\0');
        return header + body;
    }

    std::vector<int> ramp(int start)
    {
        std::vector<int> stored;
        for (int p = 0; p < test_support::kTestColumns * test_support::kTestRows; ++p)
            stored.push_back(start + 17 * p);
        return stored;
    }

    void write_rle(const fs::path& path, test_support::DicomBytes data, const std::vector<std::string>& fragments)
    {
        data.fragments(0x7FE00010, fragments);
        test_support::write_bytes(path, test_support::dicom_file(data, test_support::kEnhancedCtStorage, kRleSyntax));
    }

    TEST(DicomCodecs, FramesAreFoundWithAndWithoutTheTableOfOffsets)
    {
        const test_support::TemporaryFolder folder;
        const test_support::DicomBytes tags = test_support::enhanced_ct({ 3, 0 }, { 1, 1 });
        const std::string one = rle(ramp(1000));
        const std::string two = rle(ramp(2000));
        const auto expect_frames = [&] {
            const mesh::Volume volume = read_dicom(folder / "ct").volume;
            ASSERT_EQ(volume.grid.size[2], 2);
            for (int p = 0; p < test_support::kTestColumns * test_support::kTestRows; ++p) {
                ASSERT_EQ(
                    volume
                        .voxels[volume.grid.offset(p % test_support::kTestColumns, p / test_support::kTestColumns, 0)],
                    2000 + 17 * p - 1024);
                ASSERT_EQ(
                    volume
                        .voxels[volume.grid.offset(p % test_support::kTestColumns, p / test_support::kTestColumns, 1)],
                    1000 + 17 * p - 1024);
            }
        };
        write_rle(folder / "ct", tags, { "", one, two });
        expect_frames();
        const auto table = [&](std::size_t second) {
            return test_support::DicomBytes::number(0, 4)
                + test_support::DicomBytes::number(static_cast<std::int64_t>(second), 4);
        };
        write_rle(folder / "ct", tags, { table(8 + one.size()), one, two });
        expect_frames();
        const std::size_t half = one.size() / 2;
        write_rle(folder / "ct", tags, { table(16 + one.size()), one.substr(0, half), one.substr(half), two });
        expect_frames();

        const auto refused = [&](const std::string& why) {
            test_support::expect_refused<InputError>([&] { read_dicom(folder / "ct"); }, why);
        };
        write_rle(folder / "ct", tags, { "", one.substr(0, half), one.substr(half), two });
        refused("in which of their 3 fragments an image begins");
        write_rle(folder / "ct", tags, { table(14), one.substr(0, half), one.substr(half), two });
        refused("the table of offsets");
        write_rle(folder / "ct", tags, { "", one });
        refused("1 fragments for 2 images");
        write_rle(folder / "ct", tags, { "", one, two.substr(0, 70) });
        refused("cannot be decoded");
        write_rle(folder / "ct", tags, { "", one, "" });
        refused("cannot be decoded");
    }

    TEST(DicomCodecs, AStreamThatContradictsTheTagsIsRefused)
    {
        const test_support::TemporaryFolder folder;
        const auto refused = [&](const std::string& stream, const std::string& why) {
            test_support::DicomBytes slice = test_support::ct_slice(0.0, 1);
            slice.fragments(0x7FE00010, { "", stream });
            test_support::write_bytes(
                folder / "ct", test_support::dicom_file(slice, test_support::kCtStorage, kJpegLosslessSyntax));
            test_support::expect_refused<InputError>([&] { read_dicom(folder / "ct"); }, why);
        };
        const std::string start = "\xFF\xD8";
        const std::string end = "\xFF\xD9";
        const auto frame = [](int columns, int rows, int bits, int components) {
            std::string segment = "\xFF\xC3";
            segment += std::string("\0\x0B", 2) + static_cast<char>(bits);
            for (const int value : { rows, columns }) {
                segment += static_cast<char>(value >> 8);
                segment += static_cast<char>(value & 0xFF);
            }
            return segment + static_cast<char>(components) + std::string("\1\x11\0", 3);
        };
        refused("hello", "no start of image");
        refused(start + frame(6, 5, 16, 1), "no end of image");
        refused(
            start + frame(6, 500, 16, 1) + end, "the compressed image is 6 x 500 of 16 bits, the tags say 6 x 5 of 16");
        refused(start + frame(6, 5, 8, 1) + end, "6 x 5 of 8 bits");
        refused(start + frame(6, 5, 16, 3) + end, "the compressed image is");
        refused(start + end, "the compressed image is 0 x 0");
        refused(start + frame(6, 5, 16, 1) + end, "cannot be decoded");
    }

    TEST(DicomCodecs, CompressionMustBeWhatTheTransferSyntaxSays)
    {
        const test_support::TemporaryFolder folder;
        const auto refused = [&](const test_support::DicomBytes& slice, const char* syntax, const std::string& why) {
            test_support::write_bytes(folder / "ct", test_support::dicom_file(slice, test_support::kCtStorage, syntax));
            test_support::expect_refused<InputError>([&] { read_dicom(folder / "ct"); }, why);
        };
        refused(test_support::ct_slice(0.0, 1), kRleSyntax, "not in fragments");
        test_support::DicomBytes slice = test_support::ct_slice(0.0, 1);
        slice.fragments(0x7FE00010, { "", rle(ramp(1000)) });
        refused(slice, "1.2.840.10008.1.2.1", "not plain");
        refused(
            slice, "1.2.840.10008.1.2.4.103", "unsupported compression, transfer syntax \"1.2.840.10008.1.2.4.103\"");
        slice.u16(0x00280010, 65535).u16(0x00280011, 65535);
        refused(slice, kRleSyntax, "65535 x 65535 cannot be in");
    }

    TEST(DicomCodecs, BigEndianFilesAreRead)
    {
        const auto big = [](int value) {
            return std::string { static_cast<char>((value >> 8) & 0xFF), static_cast<char>(value & 0xFF) };
        };
        std::string data;
        const auto add = [&](int group, int element, const char* vr, std::string value) {
            value.resize(value.size() + value.size() % 2, ' ');
            const bool is_long = std::string(vr) == "OW";
            data += big(group) + big(element) + vr + (is_long ? std::string(4, '\0') : std::string())
                + big(static_cast<int>(value.size())) + value;
        };
        add(0x0008, 0x0060, "CS", "CT");
        add(0x0018, 0x0050, "DS", "1");
        add(0x0020, 0x0032, "DS", "0\\0\\0");
        add(0x0020, 0x0037, "DS", "1\\0\\0\\0\\1\\0");
        add(0x0028, 0x0002, "US", big(1));
        add(0x0028, 0x0004, "CS", "MONOCHROME2");
        add(0x0028, 0x0010, "US", big(3));
        add(0x0028, 0x0011, "US", big(4));
        add(0x0028, 0x0030, "DS", "1\\1");
        add(0x0028, 0x0100, "US", big(16));
        add(0x0028, 0x0101, "US", big(16));
        add(0x0028, 0x0103, "US", big(1));
        std::string pixels;
        std::vector<std::int16_t> expected;
        for (int p = 0; p < 12; ++p) {
            expected.push_back(static_cast<std::int16_t>(300 * p - 900));
            pixels += big(expected.back());
        }
        add(0x7FE0, 0x0010, "OW", pixels);
        const test_support::TemporaryFolder folder;
        test_support::write_bytes(folder / "big",
            test_support::dicom_file(test_support::DicomBytes(), test_support::kCtStorage, "1.2.840.10008.1.2.2")
                + data);
        EXPECT_EQ(read_dicom(folder / "big").volume.voxels, expected);
    }

} // namespace dicom_codecs_test
} // namespace retractor::datasets
