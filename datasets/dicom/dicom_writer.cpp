#include "datasets/dicom/dicom.h"

#include "mesh/base/error.h"
#include "mesh/base/vtk_errors.h"

#include <vtkDICOMCTGenerator.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMWriter.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <algorithm>
#include <regex>
#include <string>

#include <unistd.h>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    void check(const mesh::Volume& volume)
    {
        mesh::check_grid(volume.grid);
        if (volume.voxels.size() != volume.grid.voxel_count())
            throw InputError("the CT has " + std::to_string(volume.voxels.size()) + " voxels, its grid "
                + std::to_string(volume.grid.voxel_count()));
    }

    /// @throws IoError when the path is a file, and when the folder holds other files than IM0001.dcm ...
    void check_replaceable(const fs::path& folder)
    {
        if (!fs::exists(folder))
            return;
        if (!fs::is_directory(folder))
            throw IoError("a file of this name is in the way", folder.string());
        static const std::regex kOurs("IM[0-9]{4,}\\.dcm");
        for (const auto& entry : fs::directory_iterator(folder))
            if (!entry.is_regular_file() || !std::regex_match(entry.path().filename().string(), kOurs))
                throw IoError("the folder holds other files (" + entry.path().filename().string()
                        + "); a series is written to a folder of its own",
                    folder.string());
    }

    void fill_meta_data(vtkDICOMMetaData* data, const mesh::Volume& volume, const DicomOptions& options)
    {
        data->Set(DC::PatientName, options.patient_name);
        data->Set(DC::PatientID, options.patient_id);
        data->Set(DC::StudyDescription, "Retractor phantom");
        data->Set(DC::SeriesDescription, options.series_description);
        data->Set(DC::SeriesNumber, 1);
        data->Set(DC::PatientPosition, "HFS");
        data->Set(DC::Manufacturer, "Retractor");
        data->Set(DC::KVP, "120");
        data->Set(DC::RescaleType, "HU");
        data->Set(DC::SliceThickness, volume.grid.spacing.z());
        data->Set(DC::WindowCenter, "40");
        data->Set(DC::WindowWidth, "400");
    }

    /// @param target for messages
    void write_files(
        const fs::path& folder, const fs::path& target, const mesh::Volume& volume, const DicomOptions& options)
    {
        const mesh::ImageGrid& grid = volume.grid;
        // CT scanners store unsigned numbers with an intercept of -1024. Darker padding lowers the intercept.
        const int darkest = *std::min_element(volume.voxels.begin(), volume.voxels.end());
        const int intercept = std::min(-1024, darkest);
        vtkNew<vtkImageData> image;
        image->SetDimensions(grid.size[0], grid.size[1], grid.size[2]);
        image->SetSpacing(grid.spacing.x(), grid.spacing.y(), grid.spacing.z());
        image->AllocateScalars(VTK_UNSIGNED_SHORT, 1);
        auto* stored = static_cast<std::uint16_t*>(image->GetScalarPointer());
        for (std::size_t v = 0; v < volume.voxels.size(); ++v)
            stored[v] = static_cast<std::uint16_t>(volume.voxels[v] - intercept);

        vtkNew<vtkMatrix4x4> pose;
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c)
                pose->SetElement(r, c, grid.direction(r, c));
            pose->SetElement(r, 3, grid.origin[r]);
        }
        vtkNew<vtkDICOMMetaData> data;
        fill_meta_data(data, volume, options);
        vtkNew<vtkDICOMCTGenerator> generator;
        vtkNew<vtkDICOMWriter> writer;
        const VtkErrorTrap errors; // the writer does not pass on what its parts report
        writer->SetInputData(image);
        writer->SetGenerator(generator);
        writer->SetMetaData(data);
        writer->SetSeriesDescription(options.series_description.c_str());
        writer->SetPatientMatrix(pose);
        writer->SetMemoryRowOrderToFileNative();
        writer->SetFileSliceOrderToSame();
        writer->SetRescaleSlope(1.0);
        writer->SetRescaleIntercept(intercept);
        writer->SetFilePrefix(folder.string().c_str());
        writer->SetFilePattern("%s/IM%04d.dcm");
        writer->Write();
        const std::string text = errors.errors();
        if (text.empty() && writer->GetErrorCode() == 0)
            return;
        const bool full = text.find("Out of disk space") != std::string::npos;
        throw IoError("cannot write the DICOM series: " + (full ? "No space left on device" : text), target.string());
    }

} // namespace

void write_dicom_series(const fs::path& folder, const mesh::Volume& volume, const DicomOptions& options)
{
    check(volume);
    const fs::path target = folder.has_filename() ? folder : folder.parent_path(); // "series/" becomes "series"
    check_replaceable(target);
    const fs::path temporary
        = target.parent_path() / ("." + target.filename().string() + "." + std::to_string(::getpid()));
    try {
        fs::remove_all(temporary);
        fs::create_directories(temporary);
        write_files(temporary, target, volume, options);
        fs::remove_all(target);
        fs::rename(temporary, target);
    } catch (const fs::filesystem_error& error) {
        std::error_code ignored;
        fs::remove_all(temporary, ignored);
        throw IoError(std::string("cannot write the DICOM series: ") + error.what(), target.string());
    } catch (...) {
        std::error_code ignored;
        fs::remove_all(temporary, ignored);
        throw;
    }
}

} // namespace retractor::datasets
