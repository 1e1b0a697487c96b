#include "datasets/labels/dicom_labels.h"

#include "datasets/io/volume_io.h"
#include "datasets/labels/contour_fill.h"
#include "datasets/labels/label_import.h"
#include "datasets/labels/segment_layers.h"
#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"

#include <dcmtk/config/osconfig.h> // before the other headers of DCMTK

#include <dcmtk/dcmdata/dctk.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

namespace retractor::datasets {
namespace dicom_labels_test {

    namespace fs = std::filesystem;

    fs::path seg(const std::string& name) { return test_support::shared_data("dicom_objects/seg/" + name); }

    std::size_t voxels_of(const SegmentedImage& image, const Segment& segment)
    {
        std::size_t count = 0;
        const auto layers = static_cast<std::size_t>(image.layers);
        for (std::size_t v = static_cast<std::size_t>(segment.layer); v < image.voxels.size(); v += layers)
            count += image.voxels[v] == segment.value ? 1 : 0;
        return count;
    }

    TEST(DicomSegmentation, TheLiverIsThatOfTheNrrd)
    {
        if (!fs::exists(seg("liver.dcm")))
            GTEST_SKIP() << "the shared data are not here";
        ASSERT_TRUE(is_dicom_labels(seg("liver.dcm")));
        EXPECT_FALSE(is_dicom_labels(seg("liver_seg.nrrd")));
        EXPECT_FALSE(is_dicom_labels(seg("ct-3slice/01.dcm")));
        const mesh::LabelVolume dicom = import_labels(seg("liver.dcm")).labels;
        ASSERT_EQ(dicom.table.size(), 1U);
        EXPECT_EQ(dicom.table.front().name, "liver");
        const mesh::LabelVolume truth = read_label_voxels(seg("liver_seg.nrrd"));
        std::size_t inside = 0, different = 0;
        for (int k = 0; k < truth.grid.size[2]; ++k)
            for (int j = 0; j < truth.grid.size[1]; ++j)
                for (int i = 0; i < truth.grid.size[0]; ++i) {
                    const bool here = truth.voxels[truth.grid.offset(i, j, k)] != 0;
                    inside += here ? 1 : 0;
                    different += here != (mesh::label_at(dicom, truth.grid.world(Vec3(i, j, k))) != 0) ? 1 : 0;
                }
        EXPECT_EQ(inside, 107098U);
        EXPECT_EQ(different, 0U);
    }

    TEST(DicomSegmentation, SegmentsThatOverlapKeepTheirVoxels)
    {
        if (!fs::exists(seg("partial_overlaps.dcm")))
            GTEST_SKIP() << "the shared data are not here";
        const SegmentedImage image = read_dicom_labels(seg("partial_overlaps.dcm"));
        ASSERT_EQ(image.segments.size(), 5U);
        EXPECT_GT(image.layers, 1);
        const std::vector<std::size_t> known { 9602, 11888, 10743, 6693, 4713 };
        for (std::size_t n = 0; n < known.size(); ++n)
            EXPECT_EQ(voxels_of(image, image.segments[n]), known[n]) << image.segments[n].name;
    }

    TEST(DicomSegmentation, DamagedFilesAreRefusedOrRead)
    {
        if (!fs::exists(seg("liver.dcm")))
            GTEST_SKIP() << "the shared data are not here";
        std::ifstream in(seg("liver.dcm"), std::ios::binary);
        const std::string whole { std::istreambuf_iterator<char>(in), {} };
        const fs::path file = fs::path(testing::TempDir()) / "damaged.dcm";
        for (const double share : { 0.02, 0.2, 0.5, 0.9 }) {
            std::ofstream(file, std::ios::binary)
                << whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size())));
            EXPECT_THROW((void)read_dicom_labels(file), InputError) << share;
        }
        EXPECT_THROW((void)read_dicom_labels(seg("ct-3slice/01.dcm")), InputError);
    }

    TEST(StructureSet, APhantomsContoursAreReadWithoutItsImages)
    {
        const fs::path file = test_support::shared_data("dicom_objects/rtstruct/rtstruct.dcm");
        if (!fs::exists(file))
            GTEST_SKIP() << "the shared data are not here";
        ASSERT_TRUE(is_dicom_labels(file));
        try {
            EXPECT_FALSE(read_dicom_labels(file).segments.empty());
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()), "");
        }
    }

    /// A structure set of our own: each structure with its contours.
    struct Drawn {
        std::string name;
        std::vector<std::vector<Vec3>> contours;
    };

    fs::path structure_set(const std::vector<Drawn>& structures)
    {
        DcmFileFormat format;
        DcmDataset& data = *format.getDataset();
        data.putAndInsertString(DCM_SOPClassUID, UID_RTStructureSetStorage);
        data.putAndInsertString(DCM_SOPInstanceUID, "1.2.826.0.1.3680043.10.1");
        data.putAndInsertString(DCM_Modality, "RTSTRUCT");
        data.putAndInsertString(DCM_StructureSetLabel, "test");
        for (std::size_t n = 0; n < structures.size(); ++n) {
            const std::string number = std::to_string(n + 1);
            DcmItem* item = nullptr;
            data.findOrCreateSequenceItem(DCM_StructureSetROISequence, item, -2);
            item->putAndInsertString(DCM_ROINumber, number.c_str());
            item->putAndInsertString(DCM_ROIName, structures[n].name.c_str());
            item->putAndInsertString(DCM_ReferencedFrameOfReferenceUID, "1.2.3");
            item->putAndInsertString(DCM_ROIGenerationAlgorithm, "MANUAL");
            data.findOrCreateSequenceItem(DCM_ROIContourSequence, item, -2);
            item->putAndInsertString(DCM_ReferencedROINumber, number.c_str());
            for (const std::vector<Vec3>& contour : structures[n].contours) {
                DcmItem* drawn = nullptr;
                item->findOrCreateSequenceItem(DCM_ContourSequence, drawn, -2);
                drawn->putAndInsertString(DCM_ContourGeometricType, "CLOSED_PLANAR");
                drawn->putAndInsertString(DCM_NumberOfContourPoints, std::to_string(contour.size()).c_str());
                std::string text;
                for (const Vec3& point : contour)
                    for (int axis = 0; axis < 3; ++axis)
                        text += (text.empty() ? "" : "\\") + std::to_string(point[axis]);
                drawn->putAndInsertString(DCM_ContourData, text.c_str());
            }
        }
        const fs::path file = fs::path(testing::TempDir()) / "structures.dcm";
        EXPECT_TRUE(format.saveFile(file.c_str(), EXS_LittleEndianExplicit).good());
        return file;
    }

    std::vector<Vec3> circle(const Vec3& centre, double radius)
    {
        constexpr int kPoints = 180;
        std::vector<Vec3> points;
        for (int n = 0; n < kPoints; ++n) {
            const double angle = 2.0 * std::numbers::pi * n / kPoints;
            points.push_back(centre + radius * Vec3(std::cos(angle), std::sin(angle), 0.0));
        }
        return points;
    }

    TEST(StructureSet, CylindersHaveTheirVolumeAndHolesAreHoles)
    {
        std::vector<Drawn> drawn { { "aorta", {} }, { "heart", {} } };
        for (int n = 0; n < 10; ++n) {
            const Vec3 centre(-12.3, 40.7, 100.0 + 3.0 * n);
            drawn[0].contours.push_back(circle(centre, 12.0));
            drawn[1].contours.push_back(circle(centre, 40.0));
            drawn[1].contours.push_back(circle(centre, 20.0)); // a hole, round the aorta
        }
        const SegmentedImage image = read_dicom_labels(structure_set(drawn));
        ASSERT_EQ(image.segments.size(), 2U);
        EXPECT_EQ(image.layers, 1) << "the aorta lies in the hole";
        EXPECT_NEAR(image.grid.spacing.z(), 3.0, 1e-6);
        constexpr double kFilled = 0.04; // voxels of 1 mm in circles of 12 mm round the middle of a voxel
        const auto volume = [&](std::size_t n) {
            return static_cast<double>(voxels_of(image, image.segments[n])) * image.grid.voxel_volume();
        };
        EXPECT_NEAR(volume(0) / (30.0 * std::numbers::pi * 144.0), 1.0, kFilled);
        EXPECT_NEAR(volume(1) / (30.0 * std::numbers::pi * (1600.0 - 400.0)), 1.0, kFilled);
        const mesh::LabelVolume labels = import_labels(structure_set(drawn)).labels;
        EXPECT_EQ(mesh::find_label(labels.table, "aorta")->id, mesh::label_at(labels, { -12.3, 40.7, 112.0 }));
    }

    TEST(StructureSet, PlanesMayBeRoundedAndNamesMayHaveUmlauts)
    {
        Drawn vessel { "Gef\xe4\xdf", {} }; // Latin-1, and the file names no character set
        for (int n = 0; n < 60; ++n)
            vessel.contours.push_back(circle({ 0.0, 0.0, 2.5 * n + (n % 3 - 1) * 0.004 }, 10.0));
        const SegmentedImage image = read_dicom_labels(structure_set({ vessel }));
        EXPECT_EQ(image.grid.size[2], 60);
        EXPECT_NEAR(image.grid.spacing.z(), 2.5, 1e-3);
        EXPECT_EQ(image.segments.front().name, "Gef__");
    }

    TEST(StructureSet, WhatCannotBeFilledIsRefused)
    {
        std::vector<Vec3> tilted = circle({ 0.0, 0.0, 0.0 }, 10.0);
        tilted.front().z() += 5.0;
        EXPECT_THROW((void)read_dicom_labels(structure_set({ { "tilted", { tilted } } })), InputError);
        const std::vector<std::vector<Vec3>> uneven { circle({ 0.0, 0.0, 0.0 }, 10.0), circle({ 0.0, 0.0, 3.0 }, 10.0),
            circle({ 0.0, 0.0, 7.5 }, 10.0) };
        EXPECT_THROW((void)read_dicom_labels(structure_set({ { "uneven", uneven } })), InputError);
        EXPECT_THROW((void)read_dicom_labels(structure_set({ { "nothing", {} } })), InputError);
    }

    TEST(ContourFill, ASquareFillsItsVoxelsOnce)
    {
        mesh::ImageGrid grid;
        grid.size = { 10, 8, 2 };
        std::vector<std::uint8_t> voxels(grid.voxel_count(), 0);
        const Contour square { { { 1.5, 1.5, 1.0 }, { 5.5, 1.5, 1.0 }, { 5.5, 4.5, 1.0 }, { 1.5, 4.5, 1.0 } } };
        fill_contour(grid, square, voxels);
        EXPECT_EQ(std::accumulate(voxels.begin(), voxels.end(), 0), 12);
        EXPECT_EQ(voxels[grid.offset(2, 2, 1)], 1);
        EXPECT_EQ(voxels[grid.offset(2, 2, 0)], 0);
        EXPECT_EQ(voxels[grid.offset(6, 2, 1)], 0);
        fill_contour(grid, square, voxels);
        EXPECT_EQ(std::accumulate(voxels.begin(), voxels.end(), 0), 0) << "filled twice is empty";
    }

    TEST(SegmentLayers, OverlapsTakeAnotherLayer)
    {
        mesh::ImageGrid grid;
        grid.size = { 4, 1, 1 };
        SegmentLayers layers(grid);
        EXPECT_TRUE(layers.add("1", "left", { 1, 1, 0, 0 }));
        EXPECT_TRUE(layers.add("2", "right", { 0, 0, 1, 1 }));
        EXPECT_TRUE(layers.add("3", "middle", { 0, 1, 1, 0 }));
        EXPECT_FALSE(layers.add("4", "nothing", { 0, 0, 0, 0 }));
        const SegmentedImage image = layers.take();
        ASSERT_EQ(image.segments.size(), 3U);
        EXPECT_EQ(image.layers, 2);
        EXPECT_EQ(image.segments[1].layer, 0);
        EXPECT_EQ(image.segments[2].layer, 1);
        EXPECT_EQ(voxels_of(image, image.segments[2]), 2U);
    }

} // namespace dicom_labels_test
} // namespace retractor::datasets
