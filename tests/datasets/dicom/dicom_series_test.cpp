#include "datasets/dicom/dicom.h"

#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"
#include "tests/datasets/dicom/dicom_bytes.h"
#include "tests/support/temporary_folder.h"

namespace retractor::datasets {
namespace dicom_series_test {

    namespace fs = std::filesystem;

    std::function<void(test_support::DicomBytes&, int)> of_series(
        const std::string& uid, const std::string& number, const std::string& description)
    {
        return [=](test_support::DicomBytes& slice, int) {
            slice.text(0x0020000E, "UI", uid).text(0x00200011, "IS", number).text(0x0008103E, "LO", description);
        };
    }

    /// What a folder from a hospital holds besides the CT.
    void add_clutter(const fs::path& folder)
    {
        test_support::DicomBytes scout = test_support::ct_slice(0.0, 1);
        scout.text(0x00080008, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER").text(0x0020000E, "UI", "1.2.9.1");
        scout.text(0x0008103E, "LO", "Topogram").text(0x00200011, "IS", "1");
        test_support::write_slice(folder / "scout", scout);

        test_support::DicomBytes same_series
            = test_support::ct_slice(1.0, 99); // some scanners put the scout into the series
        same_series.text(0x00080008, "CS", "ORIGINAL\\PRIMARY\\LOCALIZER");
        test_support::write_slice(folder / "scout_inside", same_series);

        test_support::DicomBytes capture = test_support::ct_slice(0.0, 1);
        capture.text(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.7").text(0x0020000E, "UI", "1.2.9.2");
        capture.text(0x0008103E, "LO", "Dose Report").text(0x00200011, "IS", "999");
        for (const std::uint32_t geometry : { 0x00200032U, 0x00200037U, 0x00280030U })
            capture.erase(geometry);
        test_support::write_slice(folder / "dose", capture);

        test_support::DicomBytes report;
        report.text(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.88.22").text(0x00080060, "CS", "SR");
        report.text(0x00100010, "PN", "Secret^Person").text(0x0020000E, "UI", "1.2.9.3");
        test_support::write_bytes(folder / "report", test_support::dicom_file(report, "1.2.840.10008.5.1.4.1.1.88.22"));
        report.text(0x00080060, "CS", "PR").text(0x0020000E, "UI", "1.2.9.4");
        test_support::write_bytes(folder / "state", test_support::dicom_file(report, "1.2.840.10008.5.1.4.1.1.11.1"));
        test_support::write_bytes(folder / "DICOMDIR", test_support::dicom_file(report, "1.2.840.10008.1.3.10"));

        test_support::write_bytes(folder / "readme.txt", "not an image");
        test_support::write_bytes(folder / "empty", "");
        fs::create_directories(folder / "subfolder");
    }

    std::vector<std::int16_t> slice_values(int slices)
    {
        std::vector<std::int16_t> values;
        for (int k = 0; k < slices; ++k)
            for (int j = 0; j < test_support::kTestRows; ++j)
                for (int i = 0; i < test_support::kTestColumns; ++i)
                    values.push_back(static_cast<std::int16_t>(-24 + i + 10 * j + 200 * k));
        return values;
    }

    TEST(DicomSeries, ClutterDoesNotSpoilAFolder)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 4);
        add_clutter(folder / "ct");
        const DicomVolume read = read_dicom(folder / "ct");
        EXPECT_EQ(read.volume.voxels, slice_values(4));
        EXPECT_EQ(
            read.volume.grid.size, (std::array<int, 3> { test_support::kTestColumns, test_support::kTestRows, 4 }));
        EXPECT_EQ(read.volume.grid.spacing, Vec3(0.5, 0.5, 2.0));
        EXPECT_EQ(read.volume.grid.origin, Vec3(-10.0, 20.0, 0.0));
        ASSERT_EQ(read.notes.size(), 1);
        EXPECT_EQ(read.notes[0].find("chose the largest axial CT of 4 series, #1: number 4 \"Thorax\" 4 slices"), 0);
        EXPECT_NE(read.notes[0].find("\"Topogram\" 1 slice of 6 x 5, CT localizer"), std::string::npos);
        EXPECT_NE(read.notes[0].find("CT secondary capture"), std::string::npos);
    }

    TEST(DicomSeries, ListsWhatThereIsMostSlicesFirst)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 4);
        add_clutter(folder / "ct");
        test_support::write_stack(folder / "ct", 6, of_series("1.2.4", "7", "Lung"), "lung");
        const std::vector<DicomSeries> list = list_dicom_series(folder / "ct");
        ASSERT_EQ(list.size(), 5);
        EXPECT_EQ(list[0].uid, "1.2.4");
        EXPECT_EQ(list[0].number, "7");
        EXPECT_EQ(list[0].description, "Lung");
        EXPECT_EQ(list[0].modality, "CT");
        EXPECT_EQ(list[0].kind, "");
        EXPECT_EQ(list[0].files, 6);
        EXPECT_EQ(list[0].frames, 6);
        EXPECT_EQ(list[0].columns_rows, (std::array<int, 2> { test_support::kTestColumns, test_support::kTestRows }));
        EXPECT_TRUE(list[0].axial);
        EXPECT_EQ(list[1].uid, "1.2.3.8");
        EXPECT_EQ(list[2].kind, "localizer"); // number 1 before 4 and 999
        EXPECT_EQ(list[4].kind, "secondary capture");
        EXPECT_FALSE(list[4].axial);
    }

    TEST(DicomSeries, IsChosenByUidNumberOrPlace)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 4);
        add_clutter(folder / "ct");
        test_support::write_stack(folder / "ct", 6, of_series("1.2.4", "7", "Lung"), "lung");
        for (const char* wish : { "1.2.3.8", "4", "#2" }) {
            const DicomVolume read = read_dicom(folder / "ct", { .series = wish });
            EXPECT_EQ(read.volume.grid.size[2], 4) << wish;
            EXPECT_TRUE(read.notes.empty()) << "the user chose";
        }
        EXPECT_EQ(read_dicom(folder / "ct").volume.grid.size[2], 6);
        for (const char* wish : { "8", "#9", "#0", "#x", "#" })
            test_support::expect_refused<InputError>([&] { read_dicom(folder / "ct", { .series = wish }); },
                "there is no series \"" + std::string(wish)
                    + "\"; choose by UID, number or #place among:\n  #1: number 7 \"Lung\" 6 slices");
        test_support::expect_refused<InputError>(
            [&] { read_dicom(folder / "ct", { .series = "1" }); }, "a localizer, not slices");
        test_support::expect_refused<InputError>(
            [&] { read_dicom(folder / "ct", { .series = "999" }); }, "a secondary capture, not slices");
    }

    TEST(DicomSeries, ANumberThatFitsTwoSeriesIsAsked)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 3, of_series("1.2.4", "2", "A"), "a");
        test_support::write_stack(folder / "ct", 3, of_series("1.2.5", "2", "B"), "b");
        test_support::expect_refused<InputError>(
            [&] { read_dicom(folder / "ct", { .series = "2" }); }, "\"2\" fits 2 series");
    }

    TEST(DicomSeries, TiesGoToTheLowerNumber)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 3, of_series("1.2.4", "12", "late"), "a");
        test_support::write_stack(folder / "ct", 3, of_series("1.2.5", "2", "early"), "b");
        const DicomVolume read = read_dicom(folder / "ct");
        ASSERT_EQ(read.notes.size(), 1);
        EXPECT_NE(read.notes[0].find("series, #1: number 2 \"early\""), std::string::npos) << read.notes[0];
    }

    TEST(DicomSeries, AxialGoesBeforeLargerReformats)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 3);
        const auto coronal = [](test_support::DicomBytes& slice, int s) {
            of_series("1.2.6", "5", "coronal")(slice, s);
            slice.text(0x00200037, "DS", "1\\0\\0\\0\\0\\-1")
                .text(0x00200032, "DS", test_support::position_text(0, 2.0 * s, 0));
        };
        test_support::write_stack(folder / "ct", 5, coronal, "cor");
        EXPECT_EQ(read_dicom(folder / "ct").volume.grid.size[2], 3);
        EXPECT_EQ(read_dicom(folder / "ct", { .series = "5" }).volume.grid.size[2], 5);
        for (int s = 1; s <= 3; ++s)
            fs::remove(folder / ("ct/0" + std::to_string(s) + ".dcm"));
        EXPECT_EQ(read_dicom(folder / "ct").volume.grid.size[2], 5) << "the only one";
    }

    TEST(DicomSeries, OtherModalitiesAreRefusedByName)
    {
        const test_support::TemporaryFolder folder;
        const auto mr = [](test_support::DicomBytes& slice, int) {
            slice.text(0x00080060, "CS", "MR").text(0x0020000E, "UI", "1.2.6");
        };
        test_support::write_stack(folder / "mr", 5, mr);
        test_support::expect_refused<InputError>([&] { read_dicom(folder / "mr"); }, "of modality MR, not CT");
        test_support::write_stack(folder / "mr", 3, {}, "ct");
        EXPECT_EQ(read_dicom(folder / "mr").volume.grid.size[2], 3) << "the CT beside it is read";
        test_support::expect_refused<InputError>(
            [&] { read_dicom(folder / "mr", { .series = "1.2.6" }); }, "of modality MR, not CT");
    }

    TEST(DicomSeries, EmptyUidsAreToldApartByNumberAndStudy)
    {
        const test_support::TemporaryFolder folder;
        const auto without_uids = [](const char* number) {
            return [=](test_support::DicomBytes& slice, int) {
                for (const std::uint32_t uid : { 0x00080016U, 0x00080018U, 0x0020000DU, 0x0020000EU })
                    slice.text(uid, "UI", "");
                slice.text(0x00200011, "IS", number);
            };
        };
        test_support::write_stack(folder / "ct", 3, without_uids("1"), "IM");
        EXPECT_EQ(read_dicom(folder / "ct").volume.voxels, slice_values(3));
        test_support::write_stack(folder / "ct", 4, without_uids("2"), "other");
        EXPECT_EQ(list_dicom_series(folder / "ct").size(), 2);
        EXPECT_EQ(read_dicom(folder / "ct", { .series = "1" }).volume.voxels, slice_values(3));
        EXPECT_EQ(read_dicom(folder / "ct").volume.voxels, slice_values(4));
    }

    TEST(DicomSeries, OneFileIsASliceWithItsThickness)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_slice(folder / "one", test_support::ct_slice(6.0, 1));
        const DicomVolume read = read_dicom(folder / "one");
        EXPECT_EQ(
            read.volume.grid.size, (std::array<int, 3> { test_support::kTestColumns, test_support::kTestRows, 1 }));
        EXPECT_EQ(read.volume.grid.spacing.z(), 2.0);
        EXPECT_EQ(read.volume.voxels[0], 1000 + 600 - 1024);
        ASSERT_EQ(read.notes.size(), 1);
        EXPECT_EQ(read.notes[0], "a single slice, 2 mm thick");
        test_support::write_slice(folder / "thin", test_support::ct_slice(6.0, 1).erase(0x00180050));
        test_support::expect_refused<InputError>(
            [&] { read_dicom(folder / "thin"); }, "a single slice needs a positive slice thickness");
        test_support::write_slice(folder / "thin", test_support::ct_slice(6.0, 1).text(0x00180050, "DS", "-2"));
        test_support::expect_refused<InputError>([&] { read_dicom(folder / "thin"); }, "SliceThickness (0018,0050)");
        test_support::write_bytes(folder / "text", "hello");
        test_support::expect_refused<InputError>([&] { read_dicom(folder / "text"); }, "this is no DICOM file");
    }

    TEST(DicomSeries, FoldersWithoutImagesSaySo)
    {
        const test_support::TemporaryFolder folder;
        test_support::expect_refused<IoError>([&] { list_dicom_series(folder / "absent"); }, "no such file or folder");
        fs::create_directories(folder / "outer/series_b");
        fs::create_directories(folder / "outer/series_a");
        test_support::expect_refused<InputError>([&] { list_dicom_series(folder / "outer"); },
            "its subfolders are not searched, give one of them: series_a, series_b");
        test_support::DicomBytes report;
        report.text(0x00080060, "CS", "SR");
        test_support::write_bytes(folder / "reports/1", test_support::dicom_file(report));
        test_support::expect_refused<InputError>(
            [&] { read_dicom(folder / "reports"); }, "no DICOM image: 1 object without pixels");
        test_support::expect_refused<InputError>([&] { read_dicom(folder / "reports/1"); }, "no DICOM image");
    }

    TEST(DicomSeries, DamagedFilesAreRefusedInTheirSeriesAndToldOtherwise)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(folder / "ct", 3);
        const std::string slice = test_support::dicom_file(test_support::ct_slice(6.0, 4));
        const std::string other
            = test_support::dicom_file(test_support::ct_slice(6.0, 4).text(0x0020000E, "UI", "1.2.99"));
        const std::size_t in_the_tags = slice.find("MONOCHROME2"); // behind the series UID, before the pixels
        test_support::write_bytes(folder / "ct/04.dcm", other.substr(0, in_the_tags + 4));
        const DicomVolume read = read_dicom(folder / "ct");
        EXPECT_EQ(read.volume.voxels, slice_values(3));
        ASSERT_EQ(read.notes.size(), 1);
        EXPECT_EQ(read.notes[0], "passed over 1 damaged DICOM file, of no known series: 04.dcm");
        test_support::write_bytes(folder / "ct/04.dcm", slice.substr(0, in_the_tags + 4));
        test_support::expect_refused<InputError>([&] { read_dicom(folder / "ct"); }, "04.dcm");
    }

    TEST(DicomSeries, NoPatientInNotesOrErrors)
    {
        const test_support::TemporaryFolder folder;
        std::string said;
        const auto listen = [&](const fs::path& path, const DicomReadOptions& options = {}) {
            try {
                for (const DicomSeries& series : list_dicom_series(path))
                    said += series.description + series.number + series.uid + series.kind + "\n";
                for (const std::string& note : read_dicom(path, options).notes)
                    said += note + "\n";
            } catch (const Error& error) {
                said += std::string(error.what()) + error.where() + "\n";
            }
        };
        // A technician's series description that repeats the name.
        const auto named
            = [](test_support::DicomBytes& slice, int) { slice.text(0x0008103E, "LO", "Thorax of SECRET, pid-4711"); };
        test_support::write_stack(folder / "notes", 3, [&](test_support::DicomBytes& slice, int s) {
            named(slice, s);
            slice.erase(0x00281052).u16(0x00280120, 1000);
        });
        add_clutter(folder / "notes");
        listen(folder / "notes");
        listen(folder / "notes", { .series = "#8" });
        listen(folder / "notes", { .series = "999" });
        test_support::write_stack(folder / "gap", 6, named);
        fs::remove(folder / "gap/03.dcm");
        listen(folder / "gap");
        test_support::write_slice(folder / "gap/again", test_support::ct_slice(2.0, 2));
        listen(folder / "gap");
        test_support::write_slice(
            folder / "gap/again", test_support::ct_slice(2.0, 2).text(0x00200032, "DS", "Secret\\Person\\PID-4711"));
        listen(folder / "gap");
        test_support::write_stack(folder / "phases", 2, named, "a");
        test_support::write_stack(folder / "phases", 2, named, "b");
        listen(folder / "phases");
        test_support::write_slice(folder / "mr", test_support::ct_slice(0.0, 1).text(0x00080060, "CS", "MR"));
        listen(folder / "mr");
        test_support::write_slice(folder / "colour", test_support::ct_slice(0.0, 1).u16(0x00280002, 3));
        listen(folder / "colour");
        EXPECT_GE(std::count(said.begin(), said.end(), '\n'), 12) << "the cases did not speak";
        for (const char* secret : { "Secret", "SECRET", "Person", "4711" })
            EXPECT_EQ(said.find(secret), std::string::npos) << secret << " in:\n" << said;
    }

    TEST(DicomSeries, ANumberOfFramesThatIsNoneIsRefused)
    {
        const test_support::TemporaryFolder folder;
        test_support::write_stack(
            folder / "right", 3, [](test_support::DicomBytes& slice, int) { slice.text(0x00280008, "IS", "1"); });
        EXPECT_NO_THROW(read_dicom(folder / "right"));
        for (const char* frames : { "0", "-2", "1.5", "two", "1\\2", "99999", "1e30" }) {
            test_support::write_stack(folder / "ct", 3, [&](test_support::DicomBytes& slice, int s) {
                if (s == 1)
                    slice.text(0x00280008, "IS", frames);
            });
            SCOPED_TRACE(frames);
            test_support::expect_refused<InputError>([&] { read_dicom(folder / "ct"); }, "02.dcm");
        }
    }

} // namespace dicom_series_test
} // namespace retractor::datasets
