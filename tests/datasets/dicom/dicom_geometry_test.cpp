#include "datasets/dicom/dicom.h"

#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"
#include "tests/datasets/dicom/dicom_bytes.h"
#include "tests/support/temporary_folder.h"

namespace retractor::datasets {
namespace dicom_geometry_test {

    namespace fs = std::filesystem;

    constexpr double kDegree = 3.14159265358979323846 / 180.0;

    void refused(const fs::path& folder, const std::string& why)
    {
        test_support::expect_refused<InputError>([&] { read_dicom(folder); }, why);
    }

    TEST(DicomGeometry, AMissingSliceIsNamed)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 8);
        fs::remove(folder / "ct/04.dcm");
        refused(folder / "ct",
            "usually 2 mm (positions along the normal): 4 mm between 03.dcm (at 4) and 05.dcm (at 8), probably "
            "missing: 1 "
            "slice at 6");
        fs::remove(folder / "ct/05.dcm");
        refused(folder / "ct", "6 mm between 03.dcm (at 4) and 06.dcm (at 10), probably missing: 2 slices at 6, 8");
    }

    TEST(DicomGeometry, UnevenGapsAreNamed)
    {
        const test_support::TemporaryFolder folder;
        const double heights[] = { 0.0, 2.0, 4.0, 6.7, 8.7 };
        test_support::write_stack(folder / "ct", 5, [&](test_support::DicomBytes& slice, int s) {
            slice.text(0x00200032, "DS", test_support::position_text(0.0, 0.0, heights[s]));
        });
        refused(folder / "ct", "2.7 mm between 03.dcm (at 4) and 04.dcm (at 6.7)");
        // Each gap near the usual one, and yet a slice out of its place.
        test_support::write_stack(folder / "creeping", 40, [&](test_support::DicomBytes& slice, int s) {
            slice.text(0x00200032, "DS", test_support::position_text(0.0, 0.0, 2.0 * s + (s >= 20 ? 0.15 : 0.0)));
        });
        refused(folder / "creeping", "2.15 mm between 20.dcm (at 38) and 21.dcm (at 40.15)");
    }

    TEST(DicomGeometry, RoundedPositionsAreReadAndTold)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 9, [&](test_support::DicomBytes& slice, int s) {
            slice.text(0x00200032, "DS",
                test_support::position_text(0.0, 0.0, std::round(6.25 * s) / 10.0)); // 0.625 mm, one decimal
            slice.text(0x00200013, "IS", std::to_string(s));
        });
        // Gaps of 0.6 and 0.7 mm cannot be told from a crooked series: refused.
        refused(folder / "ct", "uneven gaps");
        test_support::write_stack(folder / "ct", 9, [&](test_support::DicomBytes& slice, int s) {
            slice.text(0x00200032, "DS", test_support::position_text(0.0, 0.0, std::round(62.5 * s) / 100.0));
        });
        const DicomVolume read = read_dicom(folder / "ct");
        EXPECT_NEAR(read.volume.grid.spacing.z(), 0.625, 1e-9);
        EXPECT_TRUE(read.notes.empty()) << "half a hundredth is not worth a line";
    }

    TEST(DicomGeometry, PhasesAreNamedWithTheTagThatSeparatesThem)
    {
        const test_support::TemporaryFolder folder;
        for (int phase = 1; phase <= 3; ++phase)
            test_support::write_stack(
                folder / "ct", 4,
                [&](test_support::DicomBytes& slice, int s) {
                    slice.text(0x00200100, "IS", std::to_string(phase));
                    slice.text(0x00080033, "TM", std::to_string(100000 + 10 * phase + s));
                },
                std::to_string(phase) + "_");
        refused(folder / "ct",
            "3 images at each of 4 positions (0 to 6 mm along the normal; first: 1_01.dcm, 2_01.dcm, 3_01.dcm): phases "
            "of "
            "one 4-D series? TemporalPositionIdentifier tells them apart (1, 2, 3)");
    }

    TEST(DicomGeometry, PhasesWithoutASeparatingTagSayWhatDiffers)
    {
        const test_support::TemporaryFolder folder;
        for (int phase = 1; phase <= 2; ++phase)
            test_support::write_stack(
                folder / "ct", 3,
                [&](test_support::DicomBytes& slice, int s) {
                    slice.text(0x00080033, "TM", std::to_string(100000 + 10 * phase + s));
                },
                std::to_string(phase) + "_");
        refused(folder / "ct", "no tag tells them apart everywhere; different: ContentTime");
    }

    TEST(DicomGeometry, SingleDuplicatesAreNamed)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 5);
        test_support::write_slice(folder / "ct/other.dcm", test_support::ct_slice(4.0, 17).text(0x00200012, "IS", "2"));
        refused(folder / "ct",
            "several images at the same place: at 4 mm along the normal 03.dcm, other.dcm; different there: "
            "AcquisitionNumber");
        fs::remove(folder / "ct/other.dcm");
        fs::copy(folder / "ct/02.dcm", folder / "ct/copy.dcm");
        refused(folder / "ct", "the same image twice: at 2 mm along the normal 02.dcm, copy.dcm");
    }

    TEST(DicomGeometry, MixedOrientationsSizesAndSpacingsAreNamed)
    {
        const test_support::TemporaryFolder folder;
        const auto reset = [&](const test_support::DicomBytes& odd) {
            test_support::write_stack(folder / "ct", 4);
            test_support::write_slice(folder / "ct/odd.dcm", odd);
        };
        reset(test_support::ct_slice(8.0, 5).text(0x00200037, "DS", "1\\0\\0\\0\\0\\-1"));
        refused(folder / "ct",
            "slices of different orientations: 4 with normal (0, 0, 1) at 0 to 6 mm, first 01.dcm; 1 with normal (0, "
            "1, 0) "
            "at 20 mm, first odd.dcm");
        reset(test_support::ct_slice(8.0, 5).text(0x00280030, "DS", "0.5\\0.6"));
        refused(folder / "ct", "0.6 x 0.5 mm here, 0.5 x 0.5 mm in 01.dcm");
        reset(test_support::ct_slice(8.0, 5).u16(0x00280010, 4).raw(0x7FE00010, "OW", std::string(4 * 6 * 2, '\0')));
        refused(folder / "ct", "slices of different sizes: 6 x 4 here, 6 x 5 in 01.dcm");
    }

    TEST(DicomGeometry, TagsThatAreMissingOrNoNumbersAreNamed)
    {
        const test_support::TemporaryFolder folder;
        const auto refused_with = [&](const test_support::DicomBytes& slice, const std::string& why) {
            test_support::write_slice(folder / "odd", slice);
            refused(folder / "odd", why);
        };
        const test_support::DicomBytes good = test_support::ct_slice(0.0, 1);
        const auto change = [&](std::uint32_t tag, const char* vr, const char* value) {
            return test_support::DicomBytes(good).text(tag, vr, value);
        };
        refused_with(test_support::DicomBytes(good).erase(0x00200032), "ImagePositionPatient (0020,0032)");
        refused_with(test_support::DicomBytes(good).erase(0x00200037), "ImageOrientationPatient (0020,0037)");
        refused_with(test_support::DicomBytes(good).erase(0x00280030), "PixelSpacing (0028,0030)");
        refused_with(change(0x00200032, "DS", "1\\2"), "needs 3 numbers here, the file has 2");
        refused_with(change(0x00200032, "DS", "1\\nan\\3"), "not a finite number");
        refused_with(change(0x00200032, "DS", "1\\inf\\3"), "not a finite number");
        refused_with(change(0x00200032, "DS", "1\\2,5\\3"), "not a finite number");
        refused_with(change(0x00200032, "DS", "1\\2\\1e30"), "outside any scanner");
        refused_with(change(0x00200037, "DS", "1\\0\\0\\1\\0\\0"), "perpendicular unit vectors");
        refused_with(change(0x00200037, "DS", "0\\0\\0\\0\\0\\0"), "perpendicular unit vectors");
        refused_with(change(0x00280030, "DS", "0\\0.5"), "pixel spacing must be positive");
        refused_with(change(0x00280030, "DS", "-1\\0.5"), "pixel spacing must be positive");
        refused_with(change(0x00281053, "DS", "0"), "RescaleSlope (0028,1053)");
        refused_with(change(0x00281053, "DS", "one"), "RescaleSlope (0028,1053)");
        refused_with(change(0x00281054, "LO", "MGML"), "the values are \"MGML\", not Hounsfield units");
    }

    /// A smooth body, bent so that no axis is special; linear interpolation of it errs little.
    double body(const Vec3& world)
    {
        const double r = (world - Vec3(5.0, -3.0, 20.0)).norm();
        return 300.0 * std::cos(0.06 * world.x()) * std::cos(0.05 * world.y() + 0.04 * world.z()) - 2.0 * r;
    }

    constexpr int kSide = 40;

    /// A gantry tilted by `degrees` about x: slices turned, the table moving along z.
    void write_tilted(const fs::path& folder, double degrees, int slices, double turn = 0.0)
    {
        const Mat3 about_z = Eigen::AngleAxisd(turn * kDegree, Vec3::UnitZ()).toRotationMatrix();
        const Mat3 tilt = about_z * Eigen::AngleAxisd(degrees * kDegree, Vec3::UnitX()).toRotationMatrix();
        for (int s = 0; s < slices; ++s) {
            test_support::DicomBytes slice = test_support::ct_slice(0.0, s + 1);
            const Vec3 first = Vec3(-20.0, -20.0, 2.0 * s);
            std::vector<int> stored;
            for (int j = 0; j < kSide; ++j)
                for (int i = 0; i < kSide; ++i)
                    stored.push_back(
                        static_cast<int>(std::lround(body(first + tilt.col(0) * i + tilt.col(1) * j)) + 1024));
            slice.text(0x00200032, "DS", test_support::position_text(first.x(), first.y(), first.z()));
            slice.text(0x00200037, "DS",
                test_support::position_text(tilt(0, 0), tilt(1, 0), tilt(2, 0)) + "\\"
                    + test_support::position_text(tilt(0, 1), tilt(1, 1), tilt(2, 1)));
            slice.text(0x00280030, "DS", "1\\1").u16(0x00280010, kSide).u16(0x00280011, kSide);
            slice.raw(0x7FE00010, "OW", test_support::pixel_bytes(stored));
            test_support::write_slice(folder / ("s" + std::to_string(100 + s)), slice);
        }
    }

    void expect_body_in_place(const mesh::Volume& volume, std::size_t at_least)
    {
        // Half a unit of rounding twice, and h^2/8 times the second derivative (0.06^2 * 300) of what is between.
        constexpr double kLinear = 1.0 + 0.2;
        std::size_t inside = 0;
        for (int k = 0; k < volume.grid.size[2]; ++k)
            for (int j = 0; j < volume.grid.size[1]; ++j)
                for (int i = 0; i < volume.grid.size[0]; ++i) {
                    const int hu = volume.voxels[volume.grid.offset(i, j, k)];
                    if (hu == -1024)
                        continue;
                    ++inside;
                    ASSERT_NEAR(hu, body(volume.grid.world(Vec3(i, j, k))), kLinear) << i << " " << j << " " << k;
                }
        EXPECT_GE(inside, at_least);
    }

    TEST(DicomGeometry, TiltedGantryIsStraightenedInPlace)
    {
        constexpr int kSlices = 20;
        for (const double degrees : { 0.0, 15.0, -22.5 })
            for (const double turn : { 0.0, 30.0 }) {
                const test_support::TemporaryFolder folder;
                write_tilted(folder / "ct", degrees, kSlices, turn);
                const DicomVolume read = read_dicom(folder / "ct");
                const mesh::ImageGrid& grid = read.volume.grid;
                EXPECT_NEAR(grid.spacing.z(), 2.0 * std::cos(degrees * kDegree), 1e-6);
                // Only the ends of the columns are lost to interpolation.
                expect_body_in_place(read.volume, kSlices * (kSide - 1) * (kSide - 1));
                if (degrees == 0.0) {
                    EXPECT_TRUE(read.notes.empty());
                    continue;
                }
                EXPECT_EQ(grid.size[1] + grid.size[0] > 2 * kSide, true) << "no slice may be cut off";
                ASSERT_EQ(read.notes.size(), 1);
                EXPECT_NE(read.notes[0].find("gantry tilt of " + std::string(degrees > 0 ? "15" : "22.5") + " degrees"),
                    std::string::npos)
                    << read.notes[0];
            }
    }

    TEST(DicomGeometry, TiltIsRefusedWhenNotWanted)
    {
        const test_support::TemporaryFolder folder;
        write_tilted(folder / "ct", 15.0, 10);
        test_support::expect_refused<InputError>([&] { read_dicom(folder / "ct", { .rectify_tilt = false }); },
            "a tilted gantry, 15 degrees: slices shifted aside by 4.659 mm");
        write_tilted(folder / "steep", 50.0, 10);
        refused(folder / "steep", "more than a gantry tilts");
    }

    TEST(DicomGeometry, UnevenShiftsAreNoTilt)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 6, [&](test_support::DicomBytes& slice, int s) {
            slice.text(0x00200032, "DS", test_support::position_text(s == 3 ? 1.5 : 0.0, 0.0, 2.0 * s));
        });
        refused(folder / "ct", "04.dcm (at 6 mm along the normal) lies 1.5 mm aside");
    }

    TEST(DicomGeometry, EnhancedMultiFrameCtIsReadByItsFunctionalGroups)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_bytes(folder / "enhanced",
            test_support::dicom_file(
                test_support::enhanced_ct({ 6, 0, 3, 9 }, { 1, 1, 2, 1 }), test_support::kEnhancedCtStorage));
        const DicomVolume read = read_dicom(folder / "enhanced");
        EXPECT_EQ(
            read.volume.grid.size, (std::array<int, 3> { test_support::kTestColumns, test_support::kTestRows, 4 }));
        EXPECT_EQ(read.volume.grid.spacing, Vec3(0.5, 0.5, 3.0));
        EXPECT_EQ(read.volume.grid.origin, Vec3(-10.0, 20.0, 0.0));
        const auto first = [&](int k) { return read.volume.voxels[read.volume.grid.offset(0, 0, k)]; };
        EXPECT_EQ(first(0), 1000 - 1024);
        EXPECT_EQ(first(1), 2 * 1300 - 1024) << "the slope of its own frame";
        EXPECT_EQ(first(2), 1600 - 1024);
        EXPECT_EQ(first(3), 1900 - 1024);
        EXPECT_TRUE(read.notes.empty());
        fs::create_directories(folder / "ct");
        fs::rename(folder / "enhanced", folder / "ct/enhanced");
        const auto list = list_dicom_series(folder / "ct");
        ASSERT_EQ(list.size(), 1);
        EXPECT_EQ(list[0].frames, 4);
        EXPECT_EQ(list[0].files, 1);
        EXPECT_EQ(read_dicom(folder / "ct").volume.voxels, read.volume.voxels);
    }

    TEST(DicomGeometry, EnhancedMultiFrameCtIsRefusedLikeASeries)
    {
        const test_support::TemporaryFolder folder;
        const fs::path file = folder / "enhanced";
        const auto write = [&](const test_support::DicomBytes& data) {
            test_support::write_bytes(file, test_support::dicom_file(data, test_support::kEnhancedCtStorage));
        };
        write(test_support::enhanced_ct({ 0, 0, 3, 3, 6, 6 }, { 1, 1, 1, 1, 1, 1 }, true));
        refused(file, "2 images at each of 3 positions");
        refused(file, "TemporalPositionIndex tells them apart (1, 2)");
        write(test_support::enhanced_ct({ 0, 3, 6, 12 }, { 1, 1, 1, 1 }));
        refused(file, "6 mm between enhanced frame 3 (at 6) and enhanced frame 4 (at 12)");
        write(test_support::enhanced_ct({ 0, 3, 6 }, { 1, 1, 1 }).text(0x00280008, "IS", "4"));
        refused(file, "the pixels are truncated: 180 bytes of 240");
        write(test_support::enhanced_ct({ 0, 3, 6 }, { 1, 1, 1 }).erase(0x52009230));
        refused(file, "frame 1 ImagePositionPatient (0020,0032)");
        for (const std::uint32_t group : { 0x52009229U, 0x52009230U }) {
            // The library takes the bytes of a group for items, whatever their type says.
            write(test_support::enhanced_ct({ 0, 3, 6 }, { 1, 1, 1 }).raw(group, "OB", std::string(64, '\1')));
            refused(file, "damaged DICOM file");
        }
    }

} // namespace dicom_geometry_test
} // namespace retractor::datasets
