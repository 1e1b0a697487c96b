#include "datasets/labels/label_import.h"

#include "datasets/io/volume_io.h"
#include "datasets/labels/label_file_names.h"
#include "datasets/labels/label_presets.h"
#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"
#include "tests/support/temporary_folder.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <iterator>
#include <set>

namespace retractor::datasets {
namespace label_import_test {

    namespace fs = std::filesystem;

    constexpr double kSameVolume = 1e-3; // relative; the statistics file gives volumes of whole voxels

    using Index = std::array<int, 3>;

    mesh::ImageGrid grid_of(Index size, double spacing, const Vec3& origin)
    {
        mesh::ImageGrid grid;
        grid.size = size;
        grid.spacing = Vec3::Constant(spacing);
        grid.origin = origin;
        return grid;
    }

    mesh::LabelVolume empty_labels(const mesh::ImageGrid& grid)
    {
        return { grid, std::vector<Label>(grid.voxel_count(), 0), {} };
    }

    /// Sets the voxels from `low` to `high`, both inclusive.
    void set_box(mesh::LabelVolume& labels, Index low, Index high, Label value)
    {
        for (int k = low[2]; k <= high[2]; ++k)
            for (int j = low[1]; j <= high[1]; ++j)
                for (int i = low[0]; i <= high[0]; ++i)
                    labels.voxels[labels.grid.offset(i, j, k)] = value;
    }

    std::size_t count(const mesh::LabelVolume& labels, std::string_view name)
    {
        const mesh::LabelInfo* info = mesh::find_label(labels.table, name);
        return info == nullptr
            ? 0
            : static_cast<std::size_t>(std::count(labels.voxels.begin(), labels.voxels.end(), info->id));
    }

    std::string all_of(const std::vector<std::string>& notes)
    {
        std::string text;
        for (const std::string& note : notes)
            text += note + "\n";
        return text;
    }

    void expect_note(const ImportedLabels& imported, const std::string& part)
    {
        EXPECT_NE(all_of(imported.notes).find(part), std::string::npos) << part << " is not in:\n"
                                                                        << all_of(imported.notes);
    }

    /// Voxels only: no table beside the image.
    void write_voxels(const fs::path& path, mesh::LabelVolume labels)
    {
        labels.table.clear();
        for (const Label id : std::set<Label>(labels.voxels.begin(), labels.voxels.end()))
            if (id != 0)
                labels.table.push_back({ id, "x" + std::to_string(id), "bone", mesh::Role::wall });
        write_label_volume(path, labels);
        fs::remove(label_table_path(path));
    }

    mesh::LabelVolume three_labels()
    {
        mesh::LabelVolume labels = empty_labels(grid_of({ 10, 8, 6 }, 2.0, { -20.0, 5.0, 100.0 }));
        set_box(labels, { 1, 1, 1 }, { 3, 3, 3 }, 51);
        set_box(labels, { 5, 1, 1 }, { 6, 2, 2 }, 74);
        set_box(labels, { 8, 5, 4 }, { 8, 5, 5 }, 116);
        return labels;
    }

    TEST(LabelImport, PresetNamesTheIds)
    {
        const test_support::TemporaryFolder folder;
        write_voxels(folder / "seg.nii.gz", three_labels());
        const ImportedLabels imported = import_labels(folder / "seg.nii.gz", { .preset = "totalsegmentator" });
        EXPECT_EQ(imported.labels.table.size(), 3U); // the other 114 have no voxel
        EXPECT_EQ(count(imported.labels, "heart"), 27U);
        EXPECT_EQ(count(imported.labels, "clavicle_right"), 8U);
        EXPECT_EQ(count(imported.labels, "sternum"), 2U);
        EXPECT_EQ(imported.labels.grid.size, (Index { 10, 8, 6 }));
        expect_note(imported, "3 of its 117 structures have voxels");
    }

    TEST(LabelImport, TableBesideTheImageIsTakenAsItIs)
    {
        const test_support::TemporaryFolder folder;
        mesh::LabelVolume labels = three_labels();
        labels.table = { { 51, "my heart", "heart", mesh::Role::target }, { 74, "b", "bone", mesh::Role::wall },
            { 116, "c", "bone", mesh::Role::voxel }, { 200, "nothing of it", "fat", mesh::Role::voxel } };
        write_label_volume(folder / "seg.nrrd", labels);
        const ImportedLabels imported = import_labels(folder / "seg.nrrd");
        ASSERT_EQ(imported.labels.table.size(), 4U);
        EXPECT_EQ(imported.labels.table[0].name, "my heart");
        EXPECT_EQ(imported.labels.table[0].role, mesh::Role::target);
        EXPECT_EQ(imported.labels.voxels, labels.voxels);
        expect_note(imported, "seg.labels.json");
        expect_note(import_labels(folder / "seg.nrrd", { .preset = "totalsegmentator" }), "is not used");
    }

    TEST(LabelImport, PackedLabelsKeepTheirRegion)
    {
        const test_support::TemporaryFolder folder;
        mesh::LabelVolume labels = empty_labels(grid_of({ 8, 4, 4 }, 1.0, Vec3::Zero()));
        set_box(labels, { 0, 0, 0 }, { 2, 3, 3 }, 3); // left lung
        set_box(labels, { 1, 1, 1 }, { 1, 1, 3 }, 3 + (3 << 8)); // vessel in it
        set_box(labels, { 5, 0, 0 }, { 5, 0, 1 }, 2 << 8); // airway of no region
        set_box(labels, { 7, 0, 0 }, { 7, 3, 3 }, 30); // outside the body
        write_voxels(folder / "cip.nrrd", labels);
        const ImportedLabels imported = import_labels(folder / "cip.nrrd", { .preset = "cip" });
        ASSERT_EQ(imported.labels.table.size(), 1U);
        EXPECT_EQ(count(imported.labels, "lung_left"), 48U);
        EXPECT_EQ(std::count(imported.labels.voxels.begin(), imported.labels.voxels.end(), 0), 80);
        expect_note(imported, "airway (2 voxels), vessel (3 voxels)");
        expect_note(imported, "2 voxels have a type but no region");
        expect_note(imported, "16 voxels lie outside the body");
    }

    TEST(LabelImport, MasksOnOneGrid)
    {
        const test_support::TemporaryFolder folder;
        const mesh::ImageGrid grid = grid_of({ 12, 10, 8 }, 1.5, { 3.0, -4.0, 5.0 });
        mesh::LabelVolume heart = empty_labels(grid), aorta = empty_labels(grid), rib = empty_labels(grid);
        set_box(heart, { 2, 2, 2 }, { 7, 7, 5 }, 1); // 144
        set_box(aorta, { 5, 5, 1 }, { 6, 6, 7 }, 255); // 28, of which 16 in the heart
        write_voxels(folder / "heart.nii.gz", heart);
        write_voxels(folder / "aorta.nrrd", aorta);
        write_voxels(folder / "rib_left_1.nii.gz", rib);
        std::ofstream(folder / "statistics.json") << "{}";
        const ImportedLabels imported = import_labels(folder.path, { .preset = "totalsegmentator" });
        EXPECT_EQ(imported.labels.grid.size, grid.size);
        EXPECT_EQ(imported.labels.table.size(), 2U);
        EXPECT_EQ(count(imported.labels, "aorta"), 28U);
        EXPECT_EQ(count(imported.labels, "heart"), 128U);
        expect_note(imported, "heart: 16 voxels that smaller structures claim too went to aorta (16)");
        expect_note(imported, "1 mask without a voxel, left out: rib_left_1");
        expect_note(imported, "not read, no mask: statistics.json");
    }

    TEST(LabelImport, TheFinestGridIsKeptAndExtended)
    {
        const test_support::TemporaryFolder folder;
        // One cube of 12 mm in voxels of 3 mm, and one of 8 mm in voxels of 1 mm whose image ends within the first
        // cube.
        mesh::LabelVolume coarse = empty_labels(grid_of({ 10, 10, 10 }, 3.0, { 1.5, 1.5, 1.5 }));
        set_box(coarse, { 6, 4, 4 }, { 9, 7, 7 }, 1); // x from 18 to 30 mm, y and z from 12 to 24 mm
        mesh::LabelVolume fine = empty_labels(grid_of({ 20, 30, 30 }, 1.0, { 0.5, 0.5, 0.5 }));
        set_box(fine, { 2, 2, 2 }, { 9, 9, 9 }, 1);
        write_voxels(folder / "liver.nrrd", coarse);
        write_voxels(folder / "heart.nrrd", fine);
        const ImportedLabels imported = import_labels(folder.path);
        EXPECT_EQ(imported.labels.grid.spacing, Vec3::Ones());
        EXPECT_EQ(imported.labels.grid.origin, fine.grid.origin);
        // The outermost coarse centre lies at 28.5 mm: so far the grid reaches.
        EXPECT_EQ(imported.labels.grid.size, (Index { 29, 30, 30 }));
        EXPECT_EQ(count(imported.labels, "heart"), 512U);
        EXPECT_EQ(count(imported.labels, "liver"), 11U * 12U * 12U);
        EXPECT_EQ(mesh::find_label(imported.labels.table, mesh::label_at(imported.labels, { 20.2, 13.1, 13.1 }))->name,
            "liver");
        expect_note(imported, "heart.nrrd is kept, the finest, extended");
    }

    TEST(LabelImport, MasksOnTurnedGridsKeepTheirPlace)
    {
        const test_support::TemporaryFolder folder;
        mesh::LabelVolume first = empty_labels(grid_of({ 40, 40, 40 }, 1.0, Vec3::Zero()));
        set_box(first, { 1, 1, 1 }, { 2, 2, 2 }, 1);
        mesh::LabelVolume turned = empty_labels(grid_of({ 12, 12, 12 }, 1.25, { 18.0, 19.0, 20.0 }));
        turned.grid.direction = test_support::oblique_rotation();
        set_box(turned, { 2, 2, 2 }, { 7, 7, 7 }, 1);
        write_voxels(folder / "heart.nrrd", first);
        write_voxels(folder / "liver.nrrd", turned);
        const mesh::LabelVolume labels = import_labels(folder.path).labels;
        // Every voxel agrees with the mask at its place, and so does the volume but for the cut of voxels.
        std::size_t inside = 0;
        for (int k = 0; k < 40; ++k)
            for (int j = 0; j < 40; ++j)
                for (int i = 0; i < 40; ++i) {
                    const bool liver = mesh::label_at(turned, labels.grid.world(Vec3(i, j, k))) != 0;
                    const Label label = labels.voxels[labels.grid.offset(i, j, k)];
                    ASSERT_EQ(liver, label != 0 && find_label(labels.table, label)->name == "liver");
                    inside += liver ? 1 : 0;
                }
        constexpr double kCutVoxels = 0.05; // of 422 mm^3, whose surface has 340 voxels
        EXPECT_NEAR(static_cast<double>(inside), turned.grid.voxel_volume() * 216.0, kCutVoxels * 422.0);
    }

    TEST(LabelImport, OneStructureInTwoFilesIsJoined)
    {
        const test_support::TemporaryFolder folder;
        mesh::LabelVolume a = empty_labels(grid_of({ 6, 6, 6 }, 1.0, Vec3::Zero())), b = a;
        set_box(a, { 0, 0, 0 }, { 1, 1, 1 }, 1);
        set_box(b, { 1, 1, 1 }, { 2, 2, 2 }, 1);
        write_voxels(folder / "clavicula_left.nrrd", a);
        write_voxels(folder / "Left clavicle.nrrd", b);
        const ImportedLabels imported = import_labels(folder.path);
        EXPECT_EQ(imported.labels.table.size(), 1U);
        EXPECT_EQ(count(imported.labels, "clavicle_left"), 15U);
        expect_note(imported, "clavicle_left is joined from Left clavicle.nrrd, clavicula_left.nrrd");
    }

    TEST(LabelImport, CancelledGivesNothing)
    {
        const test_support::TemporaryFolder folder;
        write_voxels(folder / "heart.nrrd", three_labels());
        const std::atomic<bool> cancel { true };
        Job job;
        job.cancel = &cancel;
        EXPECT_TRUE(import_labels(folder.path, {}, job).labels.voxels.empty());
    }

    TEST(LabelImport, NamesInXml)
    {
        const auto names = label_names_from_xml(R"(<LabelTable>
<Label Key="0" Red="0"><![CDATA[???]]></Label>
<Label Key="5" Red="0.0" Alpha="1"><![CDATA[liver]]></Label><Label Key="7">a &lt; b &amp; c</Label></LabelTable>)",
            "file");
        EXPECT_EQ(names, (std::map<Label, std::string> { { 5, "liver" }, { 7, "a < b & c" } }));
        EXPECT_TRUE(label_names_from_xml("<NothingOfTheKind/>", "file").empty());
        test_support::expect_refused<InputError>(
            [] { label_names_from_xml("<Label Key=\"5\">liver", "file"); }, "damaged @ file");
        test_support::expect_refused<InputError>(
            [] { label_names_from_xml("<Label Key=\"70000\">liver</Label>", "file"); }, "no id from 0 to 65535");
        test_support::expect_refused<InputError>(
            [] { label_names_from_xml("<Label Key=\"5\">a</Label><Label Key=\"5\">b</Label>", "file"); }, "id 5 twice");
    }

    /// Puts an extension into the header of an uncompressed NIfTI file, as TotalSegmentator does.
    void add_extension(const fs::path& path, std::string text, std::int32_t told_size = 0)
    {
        std::ifstream in(path, std::ios::binary);
        std::string bytes { std::istreambuf_iterator<char>(in), {} };
        text.resize((text.size() + 8 + 15) / 16 * 16 - 8, ' ');
        const auto size = static_cast<std::int32_t>(text.size() + 8);
        const auto offset = static_cast<float>(352 + size);
        std::string extension(8, '\0');
        const std::int32_t written = told_size == 0 ? size : told_size;
        std::memcpy(extension.data(), &written, sizeof(written));
        std::memcpy(bytes.data() + 108, &offset, sizeof(offset));
        bytes[348] = 1;
        bytes.insert(352, extension + text);
        std::ofstream(path, std::ios::binary) << bytes;
    }

    TEST(LabelImport, NamesInTheHeaderOfNifti)
    {
        const test_support::TemporaryFolder folder;
        const fs::path path = folder / "seg.nii";
        const std::string xml
            = "<LabelTable><Label Key=\"51\"><![CDATA[heart]]></Label><Label Key=\"74\">Left "
              "lung</Label><Label Key=\"116\">lung_left</Label><Label Key=\"9\">x</Label></LabelTable>";
        write_voxels(path, three_labels());
        add_extension(path, xml);
        const ImportedLabels imported = import_labels(path);
        EXPECT_EQ(imported.labels.voxels, three_labels().voxels);
        EXPECT_EQ(imported.labels.table.size(), 3U);
        EXPECT_EQ(count(imported.labels, "heart"), 27U);
        EXPECT_EQ(count(imported.labels, "lung_left"), 8U);
        EXPECT_EQ(count(imported.labels, "lung_left_116"), 2U);
        expect_note(imported, "3 of its 4 structures have voxels");
        expect_note(imported, "lung_left occurs twice, id 116 becomes lung_left_116");
        expect_note(imported, "renamed: Left lung -> lung_left");
        test_support::expect_refused<InputError>([&] { import_labels(path, { .preset = "totalsegmentator" }); },
            "says that id 74 is clavicle_right, the file itself says Left lung");

        write_voxels(path, three_labels());
        add_extension(path, xml, 4000);
        test_support::expect_refused<InputError>(
            [&] { import_labels(path); }, "the extension of the NIfTI header is damaged");
        write_voxels(path, three_labels());
        add_extension(path, xml, -16);
        test_support::expect_refused<InputError>(
            [&] { import_labels(path); }, "the extension of the NIfTI header is damaged");
        write_voxels(path, three_labels());
        add_extension(path, "some other program's notes");
        test_support::expect_refused<InputError>([&] { import_labels(path); }, "the labels have no names");
    }

    TEST(LabelImport, IdsWithoutNamesAreRefusedWithTheirCounts)
    {
        const test_support::TemporaryFolder folder;
        const fs::path path = folder / "seg.nii.gz";
        mesh::LabelVolume labels = three_labels();
        write_voxels(path, labels);
        test_support::expect_refused<InputError>([&] { import_labels(path); },
            "the labels have no names: 51 (27 voxels), 74 (8 voxels), 116 (2 voxels); give a preset "
            "(totalsegmentator, ");
        test_support::expect_refused<InputError>([&] { import_labels(path); }, "(seg.labels.json)");
        test_support::expect_refused<InputError>([&] { import_labels(path, { .preset = "totalsegmentator-v1" }); },
            "1 label without a name in preset totalsegmentator-v1: 116 (2 voxels)");
        test_support::expect_refused<InputError>(
            [&] { import_labels(path, { .preset = "slicer" }); }, "takes the names from the file");
        test_support::expect_refused<InputError>(
            [&] { import_labels(path, { .preset = "total" }); }, "there is no preset of this name");
        std::ofstream(folder / "seg.labels.json") << R"({"frame": "LPS", "labels": [
            {"id": 51, "name": "heart", "material": "heart", "role": "at-risk"}]})";
        test_support::expect_refused<InputError>(
            [&] { import_labels(path); }, "2 labels without a name in seg.labels.json: 74 (8");
        std::ofstream(folder / "seg.labels.json") << R"({"frame": "LPS", "labels": [{"id": 0}]})";
        test_support::expect_refused<InputError>([&] { import_labels(path); }, "seg.labels.json:/labels/0/id");
    }

    /// A segmentation as 3D Slicer writes it, one voxel of each value in one layer or two.
    void write_segmentation(const fs::path& path, const std::string& segments, int layers, const std::string& voxels)
    {
        const std::string list = layers > 1 ? std::to_string(layers) + " " : "";
        std::ofstream(path, std::ios::binary) << "NRRD0004\ntype: unsigned char\ndimension: " << (layers > 1 ? 4 : 3)
                                              << "\nspace: left-posterior-superior\nsizes: " << list
                                              << "4 1 1\nspace directions: " << (layers > 1 ? "none " : "")
                                              << "(2,0,0) (0,2,0) (0,0,2)\nkinds: " << (layers > 1 ? "list " : "")
                                              << "domain domain domain\nspace origin: (1,2,3)\nencoding: ascii\n"
                                              << segments << "\n"
                                              << voxels << "\n";
    }

    std::string segment_keys(int n, const std::string& name, int layer, int value, const std::string& terms)
    {
        const std::string key = "Segment" + std::to_string(n) + "_";
        return key + "ID:=Segment_" + std::to_string(n + 1) + "\n" + key + "Name:=" + name + "\n" + key
            + "Layer:=" + std::to_string(layer) + "\n" + key + "LabelValue:=" + std::to_string(value) + "\n" + key
            + "Tags:=Segmentation.Status:inprogress|TerminologyEntry:" + terms + "|\n";
    }

    TEST(LabelImport, SegmentsOfSlicer)
    {
        const test_support::TemporaryFolder folder;
        const fs::path path = folder / "Segmentation.seg.nrrd";
        const std::string tissue = "List~SCT^85756007^Tissue~SCT^85756007^Tissue~^^~Codes~^^~^^";
        const std::string sternum = "List~SCT^123037004^Anatomical Structure~SCT^56873002^Sternum~^^~Codes~^^~^^";
        write_segmentation(path,
            segment_keys(0, "Left lung", 0, 1, tissue) + segment_keys(1, "Segment_2", 0, 2, sternum)
                + segment_keys(2, "Segment_3", 0, 3, tissue) + segment_keys(3, "Aorta", 0, 4, tissue),
            1, "1 2 3 0");
        for (const std::string preset : { "", "slicer" }) {
            const ImportedLabels imported = import_labels(path, { .preset = preset });
            EXPECT_EQ(imported.labels.table.size(), 3U);
            EXPECT_EQ(count(imported.labels, "lung_left"), 1U);
            EXPECT_EQ(count(imported.labels, "sternum"), 1U);
            EXPECT_EQ(count(imported.labels, "segment_3"), 1U);
            EXPECT_EQ(imported.labels.grid.origin, Vec3(1.0, 2.0, 3.0));
            expect_note(imported, "segment \"Segment_2\" is Sternum by its terminology");
            expect_note(imported, "1 segment without a voxel, left out: aorta");
        }
        test_support::expect_refused<InputError>([&] { import_labels(path, { .preset = "totalsegmentator" }); },
            "goes by ids, but this file names its segments");
        test_support::expect_refused<InputError>(
            [&] { import_labels(folder.path); }, "the folder has no image of labels");
    }

    TEST(LabelImport, LayeredSegmentsOfSlicer)
    {
        const test_support::TemporaryFolder folder;
        const fs::path path = folder / "Segmentation.seg.nrrd";
        const std::string none = "~~~~~~";
        // Layer fastest: the heart has three voxels, of which one is aorta too.
        write_segmentation(
            path, segment_keys(0, "Heart", 0, 1, none) + segment_keys(1, "Aorta", 1, 1, none), 2, "1 0 1 0 1 1 0 0");
        const ImportedLabels imported = import_labels(path);
        EXPECT_EQ(count(imported.labels, "heart"), 2U);
        EXPECT_EQ(count(imported.labels, "aorta"), 1U);
        expect_note(imported, "1 voxels belong to more than one segment");
    }

    TEST(LabelImport, BadImagesAreRefused)
    {
        const test_support::TemporaryFolder folder;
        test_support::expect_refused<IoError>([&] { import_labels(folder / "none.nii.gz"); }, "no such file");
        test_support::expect_refused<InputError>(
            [&] { import_labels(folder.path); }, "the folder has no image of labels");
        write_voxels(folder / "heart.nrrd", empty_labels(grid_of({ 4, 4, 4 }, 1.0, Vec3::Zero())));
        test_support::expect_refused<InputError>([&] { import_labels(folder / "heart.nrrd"); }, "no voxel is labelled");
        test_support::expect_refused<InputError>(
            [&] { import_labels(folder.path); }, "no mask of the folder has a labelled voxel");
        std::ofstream(folder / "half.nrrd")
            << "NRRD0004\ntype: float\ndimension: 3\nsizes: 2 1 1\nspace: left-posterior-superior\nspace directions: "
               "(1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: ascii\n\n1 0.5\n";
        test_support::expect_refused<InputError>(
            [&] { import_labels(folder / "half.nrrd"); }, "0.500000 is not a label");
        test_support::expect_refused<InputError>([&] { import_labels(folder.path); }, "half.nrrd");
    }

    TEST(LabelImport, MasksApartOrWithSeveralValuesAreRefused)
    {
        const test_support::TemporaryFolder folder;
        mesh::LabelVolume heart = empty_labels(grid_of({ 4, 4, 4 }, 1.0, Vec3::Zero()));
        set_box(heart, { 1, 1, 1 }, { 2, 2, 2 }, 1);
        mesh::LabelVolume liver = heart;
        liver.grid.origin = { 0.0, 0.0, 500.0 };
        write_voxels(folder / "heart.nrrd", heart);
        write_voxels(folder / "liver.nrrd", liver);
        test_support::expect_refused<InputError>(
            [&] { import_labels(folder.path); }, "the masks do not overlap in space");
        test_support::expect_refused<InputError>([&] { import_labels(folder.path); }, "liver.nrrd");
        write_voxels(folder / "liver.nrrd", three_labels());
        test_support::expect_refused<InputError>(
            [&] { import_labels(folder.path); }, "this image has 3: 51 (27 voxels)");
    }

    // --- Third-party files ---

    fs::path shared_labels(const std::string& name) { return test_support::shared_data("labels/" + name); }

    void expect_statistics(const mesh::LabelVolume& labels)
    {
        std::ifstream file(shared_labels("ts_abdomen/example_seg_fast_statistics.json"));
        const auto statistics = nlohmann::json::parse(file);
        int with_voxels = 0;
        for (const auto& [name, values] : statistics.items()) {
            const double expected = values["volume"].get<double>();
            const std::string known = describe_structure(name, 1).name;
            EXPECT_NEAR(static_cast<double>(count(labels, known)) * labels.grid.voxel_volume(), expected,
                kSameVolume * expected)
                << name;
            with_voxels += expected > 0.0 ? 1 : 0;
        }
        EXPECT_EQ(static_cast<int>(labels.table.size()), with_voxels);
        EXPECT_GE(with_voxels, 40);
    }

    TEST(LabelImport, AbdomenHasTheVolumesOfItsStatistics)
    {
        const fs::path path = shared_labels("ts_abdomen/example_seg_fast.nii.gz");
        if (!fs::exists(path))
            GTEST_SKIP() << "no shared data: set RETRACTOR_SHARED_DATA";
        const ImportedLabels by_header = import_labels(path);
        expect_note(by_header, "names from the file's header: 40 of its 117 structures have voxels");
        expect_statistics(by_header.labels);
        const ImportedLabels by_preset = import_labels(path, { .preset = "totalsegmentator" });
        expect_statistics(by_preset.labels);
        EXPECT_EQ(by_preset.labels.voxels, by_header.labels.voxels);
        test_support::expect_refused<InputError>(
            [&] { import_labels(path, { .preset = "totalsegmentator-v1" }); }, "without a name");
    }

    TEST(LabelImport, APresetThatContradictsTheFileIsRefused)
    {
        const fs::path path = shared_labels("ts_abdomen/example_ct_vertebrae_body.nii.gz");
        if (!fs::exists(path))
            GTEST_SKIP() << "no shared data: set RETRACTOR_SHARED_DATA";
        EXPECT_EQ(count(import_labels(path).labels, "vertebrae_body"), 11005U);
        test_support::expect_refused<InputError>([&] { import_labels(path, { .preset = "totalsegmentator" }); },
            "says that id 1 is spleen, the file itself says vertebrae_body");
    }

    TEST(LabelImport, ThoraxMasksOfTwoGrids)
    {
        const fs::path folder = shared_labels("ts_thorax_cta");
        if (!fs::exists(folder))
            GTEST_SKIP() << "no shared data: set RETRACTOR_SHARED_DATA";
        const test_support::TemporaryFolder copies;
        for (const std::string name : { "aorta_true_lumen", "aorta_false_lumen", "heart" }) {
            const fs::path to = copies / (name + ".nii.gz");
            fs::copy_file(folder / (name + ".nii.gz"), to);
            fs::permissions(to, fs::perms::owner_write, fs::perm_options::add);
        }
        const ImportedLabels imported = import_labels(copies.path);
        const mesh::LabelVolume& labels = imported.labels;
        EXPECT_EQ(labels.grid.size, (Index { 233, 167, 191 }));
        EXPECT_EQ(count(labels, "aorta_true_lumen"), 37595U);
        EXPECT_EQ(count(labels, "aorta_false_lumen"), 36170U);
        // Ten voxels of the lumen lie in the heart's mask too.
        EXPECT_EQ(count(labels, "heart") + 10U, 198176U);
        expect_note(imported, "heart: 10 voxels that smaller structures claim too went to aorta_true_lumen (10)");
        expect_note(imported, "heart.nii.gz is kept, the finest (233 x 167 x 191)");
        EXPECT_EQ(mesh::find_label(labels.table, "aorta_true_lumen")->role, mesh::Role::target);
        EXPECT_EQ(mesh::find_label(labels.table, "heart")->role, mesh::Role::at_risk);
    }

    TEST(LabelImport, TheWholeThoraxFolder)
    {
        const fs::path folder = shared_labels("ts_thorax_cta");
        if (!fs::exists(folder))
            GTEST_SKIP() << "no shared data: set RETRACTOR_SHARED_DATA";
        const ImportedLabels imported = import_labels(folder);
        const mesh::LabelVolume& labels = imported.labels;
        EXPECT_EQ(labels.table.size(), 19U);
        // What each structure kept and what the notes say it lost are together the voxels of its mask.
        EXPECT_EQ(count(labels, "aorta_true_lumen") + 515U, 37595U);
        expect_note(imported, "aorta_true_lumen: 515 voxels");
        EXPECT_EQ(count(labels, "aorta_false_lumen") + 19U, 36170U);
        expect_note(imported, "aorta_false_lumen: 19 voxels");
        EXPECT_EQ(count(labels, "heart") + 13209U, 198176U);
        expect_note(imported, "heart: 13209 voxels");
        EXPECT_EQ(count(labels, "aorta") + 69830U, 72810U);
        EXPECT_EQ(count(labels, "subclavian_artery_left"), 1441U);
        EXPECT_EQ(count(labels, "vertebrae_T12"), 9617U);
        expect_note(imported, "aorta_true_lumen is joined from T716_aorta_true_false_lumen.nii.gz, aorta_true_lumen");
        expect_note(imported, "not read, no mask: LICENSE, aorta_report.json, pulmonary_report.json");
    }

    TEST(LabelImport, ThoraxWithoutNamesIsRefused)
    {
        const fs::path path = shared_labels("ts_thorax_multilabel.nii.gz");
        if (!fs::exists(path))
            GTEST_SKIP() << "no shared data: set RETRACTOR_SHARED_DATA";
        test_support::expect_refused<InputError>([&] { import_labels(path); },
            "the labels have no names: 1 (37454 voxels), 2 (36160 voxels), 3 (185147 voxels)");
    }

    TEST(LabelImport, ChestImagingPlatform)
    {
        const fs::path path = shared_labels("cip_thorax/lm-64.nrrd");
        if (!fs::exists(path))
            GTEST_SKIP() << "no shared data: set RETRACTOR_SHARED_DATA";
        const ImportedLabels imported = import_labels(path, { .preset = "cip" });
        EXPECT_EQ(imported.labels.table.size(), 6U); // thirds of both lungs
        EXPECT_EQ(count(imported.labels, "lung_lower_third_right"), 11108U + 962U + 4U);
        EXPECT_EQ(count(imported.labels, "lung_upper_third_left"), 10164U + 907U + 2U);
        expect_note(imported, "523 voxels have a type but no region");
        EXPECT_EQ(
            count(import_labels(shared_labels("cip_thorax/wholeLung-64.nrrd"), { .preset = "cip" }).labels, "lungs"),
            65624U);
        test_support::expect_refused<InputError>([&] { import_labels(path); }, "the labels have no names");
    }

} // namespace label_import_test
} // namespace retractor::datasets
