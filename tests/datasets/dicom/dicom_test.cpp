#include "datasets/dicom/dicom.h"

#include "datasets/io/volume_io.h"
#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"
#include "tests/support/temporary_folder.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include <csignal>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace retractor::datasets {
namespace dicom_test {

    namespace fs = std::filesystem;

    // DICOM stores numbers as text; the writer gives them about 11 digits, here of positions up to 1000 mm.
    constexpr double kDecimalString = 1e-7;

    TEST(Dicom, ObliqueSeriesComesBackExactly)
    {
        const test_support::TemporaryFolder folder;
        const mesh::Volume written = test_support::random_volume(test_support::oblique_rotation());
        write_dicom_series(folder / "ct", written);
        const mesh::Volume read = read_dicom_series(folder / "ct");
        EXPECT_EQ(read.voxels, written.voxels);
        EXPECT_EQ(read.grid.size, written.grid.size);
        EXPECT_LT((read.grid.origin - written.grid.origin).norm(), kDecimalString);
        EXPECT_LT((read.grid.spacing - written.grid.spacing).norm(), kDecimalString);
        EXPECT_LT((read.grid.direction - written.grid.direction).norm(), kDecimalString);
    }

    TEST(Dicom, MirroredAxesKeepTheirPlaceInTheWorld)
    {
        for (int axis = 0; axis < 3; ++axis) {
            const test_support::TemporaryFolder folder;
            const mesh::Volume written = test_support::random_volume(test_support::mirrored(axis));
            write_dicom_series(folder / "ct", written);
            const mesh::Volume read = read_dicom_series(folder / "ct");
            EXPECT_GT(read.grid.direction.determinant(), 0.0) << "a series is read right-handed";
            test_support::expect_same_in_world(written, read, kDecimalString);
        }
    }

    TEST(Dicom, ValuesBelowAirAreKeptInsideTheImage)
    {
        const test_support::TemporaryFolder folder;
        mesh::Volume written = test_support::random_volume(Mat3::Identity());
        written.voxels[written.grid.offset(4, 3, 2)] = -3024; // beside metal, say
        written.voxels.back() = 32767;
        write_dicom_series(folder / "ct", written);
        EXPECT_EQ(read_dicom_series(folder / "ct").voxels, written.voxels);
    }

    TEST(Dicom, OutsideTheScanCircleIsAir)
    {
        const test_support::TemporaryFolder folder;
        mesh::Volume written = test_support::random_volume(Mat3::Identity());
        const std::size_t fills[] = { written.grid.offset(0, 0, 2), written.grid.offset(8, 0, 2),
            written.grid.offset(0, 6, 2), written.grid.offset(8, 6, 2), written.grid.offset(1, 0, 2) };
        for (const std::size_t v : fills)
            written.voxels[v] = -3024;
        written.voxels[written.grid.offset(4, 3, 2)] = -2000;
        written.voxels[written.grid.offset(0, 0, 3)] = -3024; // one corner alone is no circle
        write_dicom_series(folder / "ct", written);
        const DicomVolume read = read_dicom(folder / "ct");
        for (const std::size_t v : fills)
            written.voxels[v] = -1024;
        EXPECT_EQ(read.volume.voxels, written.voxels);
        ASSERT_EQ(read.notes.size(), 1);
        EXPECT_EQ(read.notes[0], "5 voxels outside the scan circle (-3024 HU) set to air, -1024 HU");
    }

    TEST(Dicom, FileNamesDoNotDecideTheOrder)
    {
        const test_support::TemporaryFolder folder;
        const mesh::Volume written = test_support::random_volume(test_support::oblique_rotation());
        write_dicom_series(folder / "ct", written);
        fs::rename(folder / "ct/IM0001.dcm", folder / "ct/zz");
        fs::rename(folder / "ct/IM0004.dcm", folder / "ct/aa.dcm");
        std::ofstream(folder / "ct/notes.txt") << "not an image";
        EXPECT_EQ(read_dicom_series(folder / "ct").voxels, written.voxels);
    }

    TEST(Dicom, WritingAgainReplacesTheSeriesButNothingElse)
    {
        const test_support::TemporaryFolder folder;
        mesh::Volume volume = test_support::random_volume(Mat3::Identity());
        write_dicom_series(folder / "ct", volume);
        volume.grid.size[2] = 3;
        volume.voxels.resize(volume.grid.voxel_count());
        write_dicom_series(folder / "ct", volume);
        EXPECT_EQ(read_dicom_series(folder / "ct").grid.size[2], 3);
        std::ofstream(folder / "ct/report.txt") << "someone's work";
        test_support::expect_refused<IoError>([&] { write_dicom_series(folder / "ct", volume); }, "report.txt");
        EXPECT_EQ(read_dicom_series(folder / "ct").grid.size[2], 3);
    }

    TEST(Dicom, ASeriesThatTheDiskCutsShortIsRefusedAndTheFormerStays)
    {
        const test_support::TemporaryFolder folder;
        const mesh::Volume written = test_support::random_volume(Mat3::Identity());
        write_dicom_series(folder / "ct", written);
        // In a child, as the limit on file sizes is the whole process'.
        const ::pid_t child = ::fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            static_cast<void>(::signal(SIGXFSZ, SIG_IGN));
            const ::rlimit limit { 700, 700 }; // a part of a slice
            if (::setrlimit(RLIMIT_FSIZE, &limit) != 0)
                ::_exit(2);
            try {
                write_dicom_series(folder / "ct", written);
            } catch (const IoError&) {
                ::_exit(0);
            }
            ::_exit(3);
        }
        int status = 0;
        ASSERT_EQ(::waitpid(child, &status, 0), child);
        ASSERT_TRUE(WIFEXITED(status));
        EXPECT_EQ(WEXITSTATUS(status), 0);
        EXPECT_EQ(read_dicom_series(folder / "ct").voxels, written.voxels);
    }

    TEST(Dicom, RecordsItsPart)
    {
        const test_support::TemporaryFolder folder;
        write_dicom_series(folder / "ct", test_support::random_volume(Mat3::Identity()));
        Ledger ledger;
        Job job;
        job.ledger = &ledger;
        read_volume(folder / "ct", job);
        EXPECT_TRUE(ledger.has("voxels"));
    }

    TEST(Dicom, SeriesOfTheChestImagingPlatformEqualsItsNrrd)
    {
        const fs::path series = test_support::shared_data("ct/cip_thorax/ct-64Dicom");
        if (!fs::exists(series))
            GTEST_SKIP() << "no shared data at " << series;
        const mesh::Volume dicom = read_dicom_series(series);
        const mesh::Volume nrrd = read_volume(test_support::shared_data("ct/cip_thorax/ct-64.nrrd"));
        ASSERT_EQ(dicom.grid.size, nrrd.grid.size);
        EXPECT_EQ(dicom.voxels, nrrd.voxels);
        constexpr double kSixDigits = 1e-3; // that series gives its positions with six digits
        EXPECT_LT((dicom.grid.origin - nrrd.grid.origin).norm(), kSixDigits);
        EXPECT_LT((dicom.grid.spacing - nrrd.grid.spacing).norm(), kSixDigits);
        EXPECT_LT((dicom.grid.direction - nrrd.grid.direction).norm(), kSixDigits);
    }

    TEST(Dicom, EmptyUidsAndNoSuffixesAreRead)
    {
        const fs::path series = test_support::shared_data("ct/ts_abdomen/example_ct_dicom");
        if (!fs::exists(series))
            GTEST_SKIP() << "no shared data at " << series;
        const mesh::Volume volume = read_dicom_series(series);
        EXPECT_EQ(volume.grid.size, (std::array<int, 3> { 512, 512, 20 }));
        EXPECT_NEAR(volume.grid.spacing.x(), 0.977, 1e-3); // as documented, three digits
        EXPECT_NEAR(volume.grid.spacing.z(), 2.0, 1e-9);
    }

    TEST(Dicom, TransferSyntaxesOfOneImageAgree)
    {
        const fs::path folder = test_support::shared_data("bad/wg04_transfer_syntaxes");
        if (!fs::exists(folder))
            GTEST_SKIP() << "no shared data at " << folder;
        const auto farthest = [](const mesh::Volume& a, const mesh::Volume& b) {
            int most = 0;
            for (std::size_t v = 0; v < a.voxels.size(); ++v)
                most = std::max(most, std::abs(a.voxels[v] - b.voxels[v]));
            return most;
        };
        const auto mean = [](const mesh::Volume& a, const mesh::Volume& b) {
            double sum = 0.0;
            for (std::size_t v = 0; v < a.voxels.size(); ++v)
                sum += std::abs(a.voxels[v] - b.voxels[v]);
            return sum / static_cast<double>(a.voxels.size());
        };
        for (const std::string image : { "CT1_", "CT2_" }) {
            const DicomVolume plain = read_dicom(folder / (image + "UNC"));
            for (const char* lossless : { "J2KR", "JLSL", "JPLL", "RLE" }) {
                const DicomVolume read = read_dicom(folder / (image + lossless));
                EXPECT_EQ(read.volume.voxels, plain.volume.voxels) << image << lossless;
                EXPECT_EQ(read.notes, plain.notes);
            }
            constexpr int kNearLossless = 4; // as documented
            const DicomVolume near = read_dicom(folder / (image + "JLSN"));
            EXPECT_LE(farthest(near.volume, plain.volume), kNearLossless) << image;
            EXPECT_GT(farthest(near.volume, plain.volume), 0) << image;
            EXPECT_NE(near.notes.at(0).find("compressed with loss"), std::string::npos);
            // 106:1 for a slice with a sharp scan circle: measured mean differences of 22 and 13 HU.
            constexpr double kLossy = 25.0;
            const DicomVolume lossy = read_dicom(folder / (image + "J2KI"));
            EXPECT_LE(mean(lossy.volume, plain.volume), kLossy) << image;
            EXPECT_NE(lossy.notes.at(0).find("compressed with loss"), std::string::npos);
        }
    }

    TEST(Dicom, RealTiltedGantryIsStraightened)
    {
        const fs::path series = test_support::shared_data("bad/dicom2nifti/failing/gantrytilting/001");
        if (!fs::exists(series))
            GTEST_SKIP() << "no shared data at " << series;
        const DicomVolume read = read_dicom(series);
        EXPECT_EQ(read.volume.grid.size, (std::array<int, 3> { 512, 521, 4 })); // 15 mm * sin 14 deg / 0.418 mm = 8.7
        EXPECT_NEAR(read.volume.grid.spacing.z(), 5.0 * std::cos(14.0 * std::numbers::pi / 180.0), 1e-6);
        EXPECT_EQ(read.notes.at(0).find("gantry tilt of 14 degrees straightened"), 0);
        test_support::expect_refused<InputError>([&] { read_dicom(series, { .rectify_tilt = false }); },
            "a tilted gantry, 14 degrees: slices shifted aside by 3.629 mm from IM-0001-0001.dcm");
    }

    TEST(Dicom, BadGeometryOfRealFilesIsRefused)
    {
        const fs::path failing = test_support::shared_data("bad/dicom2nifti/failing");
        if (!fs::exists(failing))
            GTEST_SKIP() << "no shared data at " << failing;
        const auto refused = [&](const char* name, const char* why) {
            test_support::expect_refused<InputError>([&] { read_dicom_series(failing / name); }, why);
        };
        refused("notavolume/001", "4 images at the same place (61.5 mm along the normal");
        refused("sliceincrement/001",
            "usually 5 mm (positions along the normal): 10 mm between IM-0001-0009-0001.dcm (at 28.107) and "
            "IM-0001-0010-0001.dcm (at 38.107), probably missing: 1 slice at 33.107");
        refused("sliceincrement/002",
            "between IM-0001-0003.dcm (at -133.749) and IM-0001-0005.dcm (at -132.25), probably missing: 1 slice at "
            "-133");
        refused("sliceorientation/001", "of modality MR, not CT");
        refused("slicecount/001", "of modality MR, not CT");
    }

    TEST(Dicom, RefusesWhatIsNoEvenStack)
    {
        const test_support::TemporaryFolder folder;
        test_support::expect_refused<IoError>([&] { read_dicom_series(folder / "absent"); }, "no such file or folder");
        fs::create_directory(folder / "empty");
        test_support::expect_refused<InputError>([&] { read_dicom_series(folder / "empty"); }, "no DICOM files");

        write_dicom_series(folder / "a", test_support::random_volume(test_support::oblique_rotation()));
        fs::copy(folder / "a/IM0002.dcm", folder / "a/again.dcm");
        test_support::expect_refused<InputError>([&] { read_dicom_series(folder / "a"); }, "the same image twice");
        fs::remove(folder / "a/again.dcm");

        fs::remove(folder / "a/IM0003.dcm");
        test_support::expect_refused<InputError>(
            [&] { read_dicom_series(folder / "a"); }, "probably missing: 1 slice at");
    }

    TEST(Dicom, RefusesTruncatedPixels)
    {
        const test_support::TemporaryFolder folder;
        write_dicom_series(folder / "ct", test_support::random_volume(Mat3::Identity()));
        const fs::path slice = folder / "ct/IM0003.dcm";
        fs::resize_file(slice, fs::file_size(slice) - 40);
        test_support::expect_refused<InputError>([&] { read_dicom_series(folder / "ct"); }, "IM0003.dcm");
    }

    TEST(Dicom, RefusesToWriteABadGrid)
    {
        const test_support::TemporaryFolder folder;
        mesh::Volume volume = test_support::random_volume(Mat3::Identity());
        volume.grid.spacing.z() = 0.0;
        test_support::expect_refused<InputError>([&] { write_dicom_series(folder / "ct", volume); }, "spacing");
        volume = test_support::random_volume(Mat3::Identity());
        volume.voxels.pop_back();
        test_support::expect_refused<InputError>([&] { write_dicom_series(folder / "ct", volume); }, "voxels");
        EXPECT_FALSE(fs::exists(folder / "ct"));
    }

} // namespace dicom_test
} // namespace retractor::datasets
