#include "datasets/io/volume_io.h"

#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"
#include "tests/support/temporary_folder.h"

#include <fstream>

namespace retractor::datasets {
namespace volume_io_test {

    namespace fs = std::filesystem;

    constexpr double kDoublePrecision = 1e-12; // NRRD writes 17 digits
    constexpr double kMetaImageText = 1e-9; // MetaImage writes numbers as text, relative to hundreds of mm
    constexpr double kSinglePrecision = 1e-3; // NIfTI stores its matrix as float: 1e-7 of about 1000 mm, over 9 voxels

    struct Case {
        const char* name;
        double tolerance_mm;
    };

    std::vector<Mat3> orientations()
    {
        return { test_support::oblique_rotation(), test_support::mirrored(0), test_support::mirrored(1),
            test_support::mirrored(2), Mat3::Identity() };
    }

    TEST(VolumeIo, EveryFormatKeepsPlaceAndValue)
    {
        const test_support::TemporaryFolder folder;
        for (const Case& format : { Case { "ct.nrrd", kDoublePrecision }, Case { "ct.mha", kMetaImageText },
                 Case { "ct.nii", kSinglePrecision }, Case { "ct.nii.gz", kSinglePrecision } })
            for (const Mat3& direction : orientations()) {
                SCOPED_TRACE(format.name);
                const mesh::Volume written = test_support::random_volume(direction);
                write_volume(folder / format.name, written);
                const mesh::Volume read = read_volume(folder / format.name);
                EXPECT_EQ(read.voxels, written.voxels);
                EXPECT_EQ(read.grid.size, written.grid.size);
                EXPECT_LT((read.grid.origin - written.grid.origin).norm(), format.tolerance_mm);
                EXPECT_LT((read.grid.spacing - written.grid.spacing).norm(), format.tolerance_mm);
                EXPECT_LT((read.grid.direction - written.grid.direction).norm(), format.tolerance_mm);
            }
    }

    TEST(ImportVolume, PaddingBecomesAirAndIsCounted)
    {
        const test_support::TemporaryFolder folder;
        mesh::Volume volume = test_support::random_volume(test_support::oblique_rotation());
        volume.voxels[3] = -2048;
        volume.voxels[8] = -3024;
        write_volume(folder / "ct.nrrd", volume);
        EXPECT_EQ(read_volume(folder / "ct.nrrd").voxels, volume.voxels);
        const ImportedVolume imported = import_volume(folder / "ct.nrrd");
        ASSERT_EQ(imported.notes.size(), 1U);
        EXPECT_NE(imported.notes[0].find("2 voxels below -1024 HU (down to -3024)"), std::string::npos);
        volume.voxels[3] = volume.voxels[8] = -1024;
        EXPECT_EQ(imported.volume.voxels, volume.voxels);
    }

    TEST(VolumeIo, NrrdInRasIsTurnedToLps)
    {
        const test_support::TemporaryFolder folder;
        std::ofstream(folder / "ras.nrrd", std::ios::binary)
            << "NRRD0004\ntype: int16\ndimension: 3\nspace: right-anterior-superior\nsizes: 2 1 1\n"
               "space directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\nendian: little\nencoding: "
               "ascii\n\n5 -7\n";
        const mesh::Volume volume = read_volume(folder / "ras.nrrd");
        EXPECT_TRUE(volume.grid.world(Vec3::Zero()).isApprox(Vec3(-10.0, -20.0, 30.0), 1e-12));
        EXPECT_TRUE(volume.grid.world(Vec3::UnitX()).isApprox(Vec3(-12.0, -20.0, 30.0), 1e-12));
        EXPECT_EQ(volume.voxels, (std::vector<std::int16_t> { 5, -7 }));
    }

    TEST(VolumeIo, WrittenNrrdNamesItsFrame)
    {
        const test_support::TemporaryFolder folder;
        write_volume(folder / "ct.nrrd", test_support::random_volume(test_support::oblique_rotation()));
        std::ifstream file(folder / "ct.nrrd", std::ios::binary);
        const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
        EXPECT_NE(text.find("space: left-posterior-superior"), std::string::npos);
        EXPECT_NE(text.find("encoding: gzip"), std::string::npos);
    }

    mesh::LabelVolume small_labels()
    {
        mesh::LabelVolume labels;
        labels.grid = test_support::random_volume(test_support::oblique_rotation()).grid;
        labels.voxels.assign(labels.grid.voxel_count(), 0);
        labels.voxels[3] = 7;
        labels.voxels[10] = 40000;
        labels.table
            = { { 7, "sternum", "bone", mesh::Role::wall }, { 40000, "aneurysm", "vessel", mesh::Role::target } };
        return labels;
    }

    TEST(LabelVolumeIo, ImageAndTableComeBack)
    {
        const test_support::TemporaryFolder folder;
        const mesh::LabelVolume written = small_labels();
        for (const char* name : { "labels.nrrd", "labels.nii.gz", "labels.mha" }) {
            write_label_volume(folder / name, written);
            EXPECT_EQ(label_table_path(folder / name), folder / "labels.labels.json");
            Ledger ledger;
            Job job;
            job.ledger = &ledger;
            const mesh::LabelVolume read = read_label_volume(folder / name, job);
            EXPECT_EQ(read.voxels, written.voxels);
            ASSERT_EQ(read.table.size(), 2U);
            EXPECT_EQ(read.table[1].id, 40000);
            EXPECT_EQ(read.table[1].name, "aneurysm");
            EXPECT_EQ(read.table[1].material, "vessel");
            EXPECT_EQ(read.table[1].role, mesh::Role::target);
            EXPECT_TRUE(ledger.has("labels"));
        }
    }

    TEST(LabelVolumeIo, RefusesABadTableWithItsPlace)
    {
        const test_support::TemporaryFolder folder;
        write_label_volume(folder / "l.nrrd", small_labels());
        const auto refused = [&](const std::string& json, const std::string& why) {
            std::ofstream(folder / "l.labels.json") << json;
            test_support::expect_refused<InputError>([&] { read_label_volume(folder / "l.nrrd"); }, why);
        };
        refused("{", "not JSON");
        refused(R"({"labels": []})", "missing \"frame\"");
        refused(R"({"frame": "RAS", "labels": []})", "/frame");
        refused(R"({"frame": "LPS", "labels": [{"id": 0, "name": "a", "material": "bone", "role": "wall"}]})",
            "/labels/0/id");
        refused(R"({"frame": "LPS", "labels": [{"id": 7, "name": "a", "material": "bone", "role": "walls"}]})",
            "/labels/0/role");
        refused(R"({"frame": "LPS", "labels": [{"id": 7, "name": "", "material": "bone", "role": "wall"}]})",
            "/labels/0/name");
        refused(R"({"frame": "LPS", "labels": [{"id": 7, "name": "a", "material": "bone", "role": "wall"},
                   {"id": 7, "name": "b", "material": "bone", "role": "wall"}]})",
            "given twice");
        refused(R"({"frame": "LPS", "labels": [{"id": 7, "name": "a", "material": "bone", "role": "wall"}]})",
            "does not name: 40000");
        fs::remove(folder / "l.labels.json");
        test_support::expect_refused<IoError>([&] { read_label_volume(folder / "l.nrrd"); }, "l.labels.json");
    }

    TEST(LabelVolumeIo, RefusesToWriteUnnamedLabels)
    {
        const test_support::TemporaryFolder folder;
        mesh::LabelVolume labels = small_labels();
        labels.table.pop_back();
        test_support::expect_refused<InputError>([&] { write_label_volume(folder / "l.nrrd", labels); }, "40000");
        EXPECT_FALSE(fs::exists(folder / "l.nrrd"));
    }

    TEST(ResampleLabels, OntoItselfAndOntoAMirroredGrid)
    {
        const mesh::LabelVolume labels = small_labels();
        EXPECT_EQ(resample_labels_to(labels, labels.grid).voxels, labels.voxels);
        mesh::ImageGrid flipped = labels.grid; // the same places, i counted from the other end
        flipped.origin = labels.grid.world(Vec3(labels.grid.size[0] - 1, 0, 0));
        flipped.direction.col(0) *= -1.0;
        const mesh::LabelVolume resampled = resample_labels_to(labels, flipped);
        EXPECT_EQ(resampled.voxels[flipped.offset(flipped.size[0] - 1 - 3, 0, 0)], 7);
        const mesh::LabelVolume back = resample_labels_to(resampled, labels.grid);
        EXPECT_EQ(back.voxels, labels.voxels);
    }

    TEST(ResampleLabels, FinerGridTakesTheNearestLabel)
    {
        const mesh::LabelVolume labels = small_labels();
        mesh::ImageGrid fine = labels.grid;
        fine.size = { 27, 21, 15 };
        fine.spacing /= 3.0;
        fine.origin = labels.grid.world(Vec3::Constant(-1.0 / 3.0));
        const mesh::LabelVolume resampled = resample_labels_to(labels, fine);
        EXPECT_EQ(std::count(resampled.voxels.begin(), resampled.voxels.end(), 7), 27);
    }

    TEST(ResampleLabels, RefusesGridsThatDoNotMeet)
    {
        const mesh::LabelVolume labels = small_labels();
        mesh::ImageGrid away = labels.grid;
        away.origin.x() += 1000.0;
        test_support::expect_refused<InputError>([&] { resample_labels_to(labels, away); }, "do not overlap");
    }

    TEST(VolumeIo, RefusesValuesThatAreNoHounsfieldUnits)
    {
        const test_support::TemporaryFolder folder;
        const auto ascii = [&](const char* type, const char* value) {
            std::ofstream(folder / "v.nrrd", std::ios::binary)
                << "NRRD0004\ntype: " << type << "\ndimension: 3\nspace: left-posterior-superior\nsizes: 1 1 1\n"
                << "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: ascii\n\n"
                << value << "\n";
        };
        ascii("float", "-812.4");
        EXPECT_EQ(read_volume(folder / "v.nrrd").voxels.front(), -812);
        ascii("float", "nan");
        test_support::expect_refused<InputError>([&] { read_volume(folder / "v.nrrd"); }, "not a Hounsfield number");
        ascii("int", "40000");
        test_support::expect_refused<InputError>([&] { read_volume(folder / "v.nrrd"); }, "not a Hounsfield number");
        ascii("float", "1.5");
        std::ofstream(folder / "v.labels.json") << R"({"frame": "LPS", "labels": []})";
        test_support::expect_refused<InputError>([&] { read_label_volume(folder / "v.nrrd"); }, "not a label");
    }

    TEST(VolumeIo, RefusesTruncatedFiles)
    {
        const test_support::TemporaryFolder folder;
        const mesh::Volume volume = test_support::random_volume(Mat3::Identity());
        for (const char* name : { "ct.nrrd", "ct.mha", "ct.nii", "ct.nii.gz" }) {
            SCOPED_TRACE(name);
            write_volume(folder / name, volume);
            fs::resize_file(folder / name, fs::file_size(folder / name) - 100);
            test_support::expect_refused<InputError>([&] { read_volume(folder / name); }, name);
        }
    }

    TEST(VolumeIo, RefusesWhatItCannotName)
    {
        const test_support::TemporaryFolder folder;
        test_support::expect_refused<IoError>([&] { read_volume(folder / "absent.nrrd"); }, "absent.nrrd");
        test_support::expect_refused<InputError>([&] { read_volume(folder / "scan.png"); }, "unknown image format");
        test_support::expect_refused<InputError>(
            [&] { write_volume(folder / "ct.mhd", test_support::random_volume(Mat3::Identity())); }, "one file");
        mesh::Volume volume = test_support::random_volume(Mat3::Identity());
        volume.grid.spacing.x() = std::nan("");
        test_support::expect_refused<InputError>([&] { write_volume(folder / "ct.nrrd", volume); }, "spacing");
        EXPECT_FALSE(fs::exists(folder / "ct.nrrd"));
    }

    TEST(LabelTablePath, KnowsSuffixesInCapitalsToo)
    {
        for (const char* name : { "seg.nii.gz", "seg.NII.GZ", "seg.nrrd" })
            EXPECT_EQ(label_table_path(std::filesystem::path("folder") / name), "folder/seg.labels.json") << name;
    }

} // namespace volume_io_test
} // namespace retractor::datasets
