#include "datasets/dicom/dicom.h"

#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"
#include "tests/datasets/dicom/dicom_bytes.h"
#include "tests/support/temporary_folder.h"

#include <atomic>

namespace retractor::datasets {
namespace dicom_pixels_test {

    namespace fs = std::filesystem;

    constexpr int kPixels = test_support::kTestColumns * test_support::kTestRows;

    std::vector<int> filled(int value) { return std::vector<int>(kPixels, value); }

    test_support::DicomBytes with_pixels(const std::vector<int>& stored)
    {
        return test_support::ct_slice(0.0, 1).raw(0x7FE00010, "OW", test_support::pixel_bytes(stored));
    }

    DicomVolume read_one(const test_support::TemporaryFolder& folder, const test_support::DicomBytes& slice)
    {
        test_support::write_slice(folder / "one", slice);
        DicomVolume read = read_dicom(folder / "one");
        EXPECT_EQ(std::erase(read.notes, "a single slice, 2 mm thick"), 1U);
        return read;
    }

    void refused(
        const test_support::TemporaryFolder& folder, const test_support::DicomBytes& slice, const std::string& why)
    {
        test_support::write_slice(folder / "one", slice);
        test_support::expect_refused<InputError>([&] { read_dicom(folder / "one"); }, why);
        test_support::expect_refused<InputError>([&] { read_dicom(folder / "one"); }, "one"); // the file
    }

    TEST(DicomPixels, EachSliceHasItsOwnRescale)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 3, [](test_support::DicomBytes& slice, int s) {
            slice.text(0x00281053, "DS", s == 1 ? "0.5" : "2").text(0x00281052, "DS", s == 2 ? "-3000.4" : "-1024");
        });
        const mesh::Volume volume = read_dicom(folder / "ct").volume;
        const auto last = [&](int k) { return volume.voxels[volume.grid.offset(5, 4, k)]; };
        EXPECT_EQ(last(0), 2 * 1045 - 1024);
        EXPECT_EQ(last(1), -402) << "1245 / 2 - 1024 = -401.5";
        EXPECT_EQ(last(2), 2 * 1445 - 3000);
    }

    TEST(DicomPixels, MissingRescaleIsTold)
    {
        const test_support::TemporaryFolder folder;
        const DicomVolume read = read_one(folder, with_pixels(filled(77)).erase(0x00281052).erase(0x00281053));
        EXPECT_EQ(read.volume.voxels, std::vector<std::int16_t>(kPixels, 77));
        ASSERT_EQ(read.notes.size(), 1);
        EXPECT_NE(read.notes[0].find("assumed 1 and 0"), std::string::npos);
    }

    TEST(DicomPixels, PaddingBecomesAirAndIsCounted)
    {
        const test_support::TemporaryFolder folder;
        std::vector<int> stored = filled(1024);
        stored[0] = stored[7] = 63536; // -2000 as GE writes it
        test_support::DicomBytes slice = with_pixels(stored).u16(0x00280103, 1);
        slice.u16(0x00280120, 63536); // the tag unsigned, the pixels signed
        DicomVolume read = read_one(folder, slice);
        EXPECT_EQ(read.volume.voxels[0], -1024);
        EXPECT_EQ(read.volume.voxels[7], -1024);
        EXPECT_EQ(read.volume.voxels[1], 0);
        ASSERT_EQ(read.notes.size(), 1);
        EXPECT_EQ(read.notes[0], "2 padding voxels (-3024 HU) set to air, -1024 HU");

        stored[8] = -1990;
        stored[9] = -1979; // past the limit
        slice = with_pixels(stored).u16(0x00280103, 1).s16(0x00280120, -2000).s16(0x00280121, -1980);
        read = read_one(folder, slice);
        EXPECT_EQ(read.volume.voxels[8], -1024);
        EXPECT_EQ(read.volume.voxels[9], -1979 - 1024);
        EXPECT_EQ(read.notes.at(0), "3 padding voxels (-3024 to -3014 HU) set to air, -1024 HU");
    }

    TEST(DicomPixels, PaddingThatTissueHasIsSaid)
    {
        const test_support::TemporaryFolder folder;
        const DicomVolume read = read_one(folder, with_pixels(filled(1024)).u16(0x00280120, 1024));
        EXPECT_EQ(read.volume.voxels, std::vector<std::int16_t>(kPixels, -1024));
        EXPECT_EQ(read.notes.at(0),
            "30 padding voxels (0 HU) set to air, -1024 HU; the file declares a value as padding that air or tissue "
            "has");
    }

    TEST(DicomPixels, TwelveBitsAreReadWithTheirSign)
    {
        const test_support::TemporaryFolder folder;
        std::vector<int> stored = filled(100);
        stored[3] = 0x0FFF;
        test_support::DicomBytes slice = with_pixels(stored).u16(0x00280101, 12).u16(0x00280102, 11);
        EXPECT_EQ(read_one(folder, slice).volume.voxels[3], 4095 - 1024);
        slice.u16(0x00280103, 1).text(0x00281052, "DS", "0");
        EXPECT_EQ(read_one(folder, slice).volume.voxels[3], -1);
        stored[3] = 0xFFFF; // the sign repeated
        slice.raw(0x7FE00010, "OW", test_support::pixel_bytes(stored));
        EXPECT_EQ(read_one(folder, slice).volume.voxels[3], -1);
        stored[3] = 0x1FFF;
        slice.raw(0x7FE00010, "OW", test_support::pixel_bytes(stored));
        refused(folder, slice, "needs more than the 12 bits of BitsStored");
    }

    TEST(DicomPixels, WhatIsNoCtImageIsRefused)
    {
        const test_support::TemporaryFolder folder;
        const test_support::DicomBytes good = with_pixels(filled(1024));
        const auto copy = [&] { return test_support::DicomBytes(good); };
        refused(folder, copy().erase(0x7FE00010), "the file has no pixels");
        refused(folder, copy().raw(0x7FE00010, "OW", ""), "the file has no pixels");
        refused(folder, copy().u16(0x00280002, 3), "this is a colour image");
        refused(folder, copy().text(0x00280004, "CS", "PALETTE COLOR"), "monochrome");
        refused(folder, copy().u16(0x00280100, 32), "32 bits per pixel");
        refused(folder, copy().u16(0x00280101, 17), "BitsStored (0028,0101)");
        refused(folder, copy().u16(0x00280102, 12), "HighBit (0028,0102)");
        refused(folder, copy().u16(0x00280103, 2), "PixelRepresentation (0028,0103)");
        refused(folder, copy().u16(0x00280011, 0), "Columns (0028,0011)");
        refused(folder, copy().u16(0x00280010, 6), "the pixels are truncated: 60 bytes of 72");
        refused(folder, copy().u16(0x00280010, 4), "more pixels than the size of the image");
        refused(folder, copy().u16(0x00280010, 65535).u16(0x00280011, 65535), "the pixels are truncated");
        refused(folder, copy().text(0x00281053, "DS", "1000"), "is not a Hounsfield number");
        refused(folder, copy().text(0x00281052, "DS", "1e9"), "column 0 row 0");
        refused(folder, copy().sequence(0x00283000, { test_support::DicomBytes().u16(0x00283002, 1) }),
            "ModalityLUTSequence");
    }

    TEST(DicomPixels, AnImageWithoutPixelsSpoilsItsSeries)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 4, [](test_support::DicomBytes& slice, int s) {
            if (s == 3)
                slice.erase(0x7FE00010);
        });
        test_support::expect_refused<InputError>([&] { read_dicom(folder / "ct"); }, "04.dcm PixelData (7fe0,0010)");
    }

    TEST(DicomPixels, ThreadsAgree)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 30);
        Job one;
        one.threads = 1;
        Job eight;
        eight.threads = 8;
        double last = 0.0;
        eight.on_progress = [&](std::string_view stage, double fraction) {
            if (stage == "read CT") {
                EXPECT_GE(fraction, last);
                last = fraction;
            }
        };
        EXPECT_EQ(read_dicom(folder / "ct", {}, one).volume.voxels, read_dicom(folder / "ct", {}, eight).volume.voxels);
        EXPECT_EQ(last, 1.0);
    }

    TEST(DicomPixels, CancelledReadingGivesNothing)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 10);
        std::atomic<bool> cancel { false };
        Job job;
        job.cancel = &cancel;
        job.on_progress = [&](std::string_view stage, double) { cancel = stage == "read CT"; };
        EXPECT_TRUE(read_dicom(folder / "ct", {}, job).volume.voxels.empty());
    }

} // namespace dicom_pixels_test
} // namespace retractor::datasets
