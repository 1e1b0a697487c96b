#include "datasets/dicom/objects/document_objects.h"
#include "datasets/dicom/objects/segmentation_object.h"

#include "datasets/dicom/dicom.h"
#include "datasets/labels/dicom_labels.h"
#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"
#include "tests/support/temporary_folder.h"

#include <dcmtk/config/osconfig.h> // before the other headers of DCMTK

#include <dcmtk/dcmdata/dctk.h>
#include <gtest/gtest.h>

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

namespace retractor::datasets {
namespace dicom_objects_test {

    namespace fs = std::filesystem;

    /// Two labels with odd shapes on an oblique, mirrored grid, and one label without a voxel.
    mesh::LabelVolume some_labels()
    {
        const mesh::Volume volume = test_support::random_volume(test_support::mirrored(2));
        mesh::LabelVolume labels { .grid = volume.grid,
            .voxels = std::vector<Label>(volume.voxels.size(), 0),
            .table = { { 3, "aorta", "vessel" }, { 7, "rib_left_5", "bone" }, { 9, "heart", "muscle" } } };
        for (std::size_t v = 0; v < labels.voxels.size(); ++v)
            labels.voxels[v] = v % 5 == 0 ? Label { 3 } : v % 7 == 0 ? Label { 7 } : Label { 0 };
        return labels;
    }

    std::string value_of(const fs::path& file, const DcmTagKey& tag)
    {
        DcmFileFormat format;
        EXPECT_TRUE(format.loadFile(OFFilename(file.c_str())).good()) << file;
        OFString value;
        format.getDataset()->findAndGetOFStringArray(tag, value);
        return value.c_str();
    }

    /// What dciodvfy (dicom3tools) says of a file; empty where the program is not installed.
    std::string report_of(const fs::path& file)
    {
        const std::string line = "command -v dciodvfy >/dev/null && dciodvfy '" + file.string() + "' 2>&1";
        std::FILE* pipe = ::popen(line.c_str(), "r");
        std::array<char, 4096> buffer {};
        std::string out;
        for (std::size_t n = 0; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
            out.append(buffer.data(), n);
        ::pclose(pipe);
        return out;
    }

    /// @param kind the name of the object that dciodvfy prints
    void expect_valid(const fs::path& file, const std::string& kind)
    {
        const std::string report = report_of(file);
        if (report.empty()) {
            std::cout << "not checked: dciodvfy (package dicom3tools) is not installed\n";
            return;
        }
        EXPECT_NE(report.find(kind), std::string::npos) << report;
        EXPECT_EQ(report.find("Error"), std::string::npos) << report;
    }

    fs::path picture_in(const test_support::TemporaryFolder& folder, int channels)
    {
        vtkNew<vtkImageData> image;
        image->SetDimensions(5, 3, 1);
        image->AllocateScalars(VTK_UNSIGNED_CHAR, channels);
        for (int y = 0; y < 3; ++y)
            for (int x = 0; x < 5; ++x)
                for (int c = 0; c < channels; ++c)
                    image->SetScalarComponentFromDouble(x, y, 0, c, c == 3 ? 255.0 : 40.0 * x + 9.0 * y + c);
        const fs::path file = folder / "picture.png";
        vtkNew<vtkPNGWriter> writer;
        writer->SetFileName(file.c_str());
        writer->SetInputData(image);
        writer->Write();
        return file;
    }

    TEST(DicomObjects, LabelsAreReadBackAsTheyWereWritten)
    {
        const test_support::TemporaryFolder folder;
        const mesh::LabelVolume labels = some_labels();
        const fs::path file = folder / "labels.dcm";
        write_segmentation(file, labels, { "aorta" }, pseudonymous_study(), new_series(kFirstResultSeries, "labels"));
        const SegmentedImage read = read_dicom_labels(file);
        ASSERT_EQ(read.segments.size(), 2U) << "a label without voxels is no segment";
        EXPECT_EQ(read.segments[0].name, "aorta");
        EXPECT_EQ(read.segments[1].name, "rib_left_5");
        std::size_t different = 0;
        for (int k = 0; k < labels.grid.size[2]; ++k)
            for (int j = 0; j < labels.grid.size[1]; ++j)
                for (int i = 0; i < labels.grid.size[0]; ++i) {
                    const Vec3 index = read.grid.index(labels.grid.world(Vec3(i, j, k)));
                    const Eigen::Vector3i at = index.array().round().cast<int>();
                    ASSERT_TRUE(read.grid.contains(at[0], at[1], at[2]));
                    constexpr double kRounded = 1e-5; // voxels: decimal strings of nine digits
                    ASSERT_LT((index - at.cast<double>()).norm(), kRounded);
                    const std::size_t v = read.grid.offset(at[0], at[1], at[2]);
                    Label found = 0;
                    for (std::size_t s = 0; s < 2; ++s)
                        if (const auto layers = static_cast<std::size_t>(read.layers);
                            read.voxels[v * layers + static_cast<std::size_t>(read.segments[s].layer)]
                            == read.segments[s].value)
                            found = s == 0 ? Label { 3 } : Label { 7 };
                    different += found != labels.voxels[labels.grid.offset(i, j, k)] ? 1 : 0;
                }
        EXPECT_EQ(different, 0U);
        // Every fifth of 63 pixels, the first in the lowest bit; the second frame follows without a gap.
        DcmFileFormat format;
        ASSERT_TRUE(format.loadFile(OFFilename(file.c_str())).good());
        const Uint8* bytes = nullptr;
        unsigned long count = 0;
        ASSERT_TRUE(format.getDataset()->findAndGetUint8Array(DCM_PixelData, bytes, &count).good());
        EXPECT_EQ(bytes[0], 0b0010'0001);
        EXPECT_EQ(bytes[1], 0b1000'0100);
        EXPECT_EQ(bytes[7] >> 7, 0) << "pixel 63 of the volume is no multiple of five";
        EXPECT_EQ(bytes[8] & 0b11, 0b10) << "pixel 65 is";
        EXPECT_EQ(value_of(file, DCM_PatientIdentityRemoved), "YES");
        EXPECT_EQ(value_of(file, DCM_Modality), "SEG");
        expect_valid(file, "Segmentation");
    }

    TEST(DicomObjects, LabelsWithoutVoxelsAreRefused)
    {
        const test_support::TemporaryFolder folder;
        mesh::LabelVolume labels = some_labels();
        std::fill(labels.voxels.begin(), labels.voxels.end(), Label { 0 });
        EXPECT_THROW(
            write_segmentation(folder / "labels.dcm", labels, {}, pseudonymous_study(), new_series(1, "labels")),
            InputError);
        EXPECT_FALSE(fs::exists(folder / "labels.dcm"));
    }

    TEST(DicomObjects, APictureKeepsItsPixels)
    {
        for (const int channels : { 1, 3, 4 }) {
            const test_support::TemporaryFolder folder;
            const fs::path file = folder / "picture.dcm";
            write_secondary_capture(
                file, picture_in(folder, channels), pseudonymous_study(), new_series(2, "pictures"), 1, "field");
            DcmFileFormat format;
            ASSERT_TRUE(format.loadFile(OFFilename(file.c_str())).good());
            const Uint8* pixels = nullptr;
            unsigned long count = 0;
            ASSERT_TRUE(format.getDataset()->findAndGetUint8Array(DCM_PixelData, pixels, &count).good());
            ASSERT_EQ(count, 46U) << "an even number of bytes";
            // Rows of VTK begin below: the first of DICOM is y = 2. Pixel x = 3, channel 1.
            EXPECT_EQ(pixels[3 * 3 + 1], 40 * 3 + 9 * 2 + (channels == 1 ? 0 : 1)) << channels;
            expect_valid(file, "SCImage");
        }
    }

    TEST(DicomObjects, AReportIsCarriedWhole)
    {
        const test_support::TemporaryFolder folder;
        const std::string pdf = "%PDF-1.4\nodd length\n%%EOF";
        std::ofstream(folder / "report.pdf") << pdf;
        const fs::path file = folder / "report.dcm";
        write_encapsulated_pdf(file, folder / "report.pdf", pseudonymous_study(), new_series(3, "report"), "Fields");
        DcmFileFormat format;
        ASSERT_TRUE(format.loadFile(OFFilename(file.c_str())).good());
        const Uint8* content = nullptr;
        unsigned long count = 0;
        ASSERT_TRUE(format.getDataset()->findAndGetUint8Array(DCM_EncapsulatedDocument, content, &count).good());
        EXPECT_EQ(std::string(reinterpret_cast<const char*>(content), pdf.size()), pdf);
        expect_valid(file, "EncapsulatedPDF");
        std::ofstream(folder / "no.pdf") << "hello";
        EXPECT_THROW(
            write_encapsulated_pdf(file, folder / "no.pdf", pseudonymous_study(), new_series(3, "report"), "Fields"),
            InputError);
    }

    TEST(DicomObjects, TheIdentityComesFromTheSourceOrFromNobody)
    {
        const test_support::TemporaryFolder folder;
        mesh::Volume ct = test_support::random_volume(Mat3::Identity());
        const fs::path source = folder / "source";
        write_dicom_series(
            source, ct, { .patient_name = "Test^Person", .patient_id = "ID-77", .series_description = "CT" });
        const DicomStudy study = study_of_series(source);
        EXPECT_FALSE(study.is_pseudonymous);
        const fs::path file = folder / "picture.dcm", hidden = folder / "hidden.dcm";
        const fs::path png = picture_in(folder, 3);
        write_secondary_capture(file, png, study, new_series(2, "pictures"), 1, "field");
        EXPECT_EQ(value_of(file, DCM_PatientName), "Test^Person");
        EXPECT_EQ(value_of(file, DCM_PatientID), "ID-77");
        const fs::path first = fs::directory_iterator(source)->path();
        EXPECT_EQ(value_of(file, DCM_StudyInstanceUID), value_of(first, DCM_StudyInstanceUID));
        EXPECT_NE(value_of(file, DCM_SeriesInstanceUID), value_of(first, DCM_SeriesInstanceUID));
        write_secondary_capture(hidden, png, pseudonymous_study(), new_series(2, "pictures"), 1, "field");
        EXPECT_EQ(value_of(hidden, DCM_PatientIdentityRemoved), "YES");
        EXPECT_EQ(value_of(hidden, DCM_PatientName).find("Pseudonym^"), 0U);
        EXPECT_THROW((void)study_of_series(png), InputError);
        // Names of any script.
        DicomStudy abroad = study;
        abroad.patient_name = "\u00d6sterreich^\u5c71\u7530";
        write_segmentation(folder / "abroad.dcm", some_labels(), {}, abroad, new_series(1, "labels"));
        EXPECT_EQ(value_of(folder / "abroad.dcm", DCM_PatientName), abroad.patient_name);
        EXPECT_LT(study.low.x(), study.high.x());
    }

} // namespace dicom_objects_test
} // namespace retractor::datasets
