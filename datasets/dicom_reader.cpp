#include "datasets/dicom.h"

#include "datasets/voxel_values.h"
#include "mesh/base/error.h"

#include <vtkCallbackCommand.h>
#include <vtkDICOMDictionary.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMParser.h>
#include <vtkDICOMReader.h>
#include <vtkDICOMUtilities.h>
#include <vtkDICOMValue.h>
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <sstream>

namespace retractor {

namespace {

    namespace fs = std::filesystem;

    /// What the tags of one file say.
    struct Slice {
        fs::path file;
        std::string series;
        std::string description;
        int columns = 0;
        int rows = 0;
        Vec3 position = Vec3::Zero();
        Vec3 row = Vec3::Zero(); ///< direction of rising column index
        Vec3 column = Vec3::Zero();
        double row_spacing = 0.0; ///< between rows
        double column_spacing = 0.0;
        double thickness = 0.0;
        double slope = 1.0;
        double intercept = 0.0;
    };

    /// VTK reports errors as events; without an observer it prints them.
    class ErrorCollector {
    public:
        explicit ErrorCollector(vtkObject* object)
        {
            command_->SetClientData(this);
            command_->SetCallback([](vtkObject*, unsigned long, void* self, void* text) {
                static_cast<ErrorCollector*>(self)->text_ += text != nullptr ? static_cast<const char*>(text) : "error";
            });
            object->AddObserver(vtkCommand::ErrorEvent, command_);
            object->AddObserver(vtkCommand::WarningEvent, ignore_);
        }
        bool failed() const { return !text_.empty(); }

    private:
        vtkNew<vtkCallbackCommand> command_;
        vtkNew<vtkCallbackCommand> ignore_;
        std::string text_;
    };

    std::string tag_name(vtkDICOMTag tag)
    {
        std::ostringstream name;
        name << tag;
        const vtkDICOMDictEntry entry = vtkDICOMDictionary::FindDictEntry(tag);
        return name.str() + (entry.IsValid() ? std::string(" ") + entry.GetName() : "");
    }

    [[noreturn]] void refuse(const std::string& what, const fs::path& file, vtkDICOMTag tag)
    {
        throw InputError(what, file.string() + " " + tag_name(tag));
    }

    /// `count` finite numbers of a tag.
    std::vector<double> numbers(vtkDICOMMetaData* data, const fs::path& file, vtkDICOMTag tag, std::size_t count)
    {
        const vtkDICOMValue& value = data->Get(tag);
        if (!value.IsValid() || value.GetNumberOfValues() != count)
            refuse("a CT slice needs " + std::to_string(count) + " value(s) here", file, tag);
        std::vector<double> result(count);
        for (std::size_t i = 0; i < count; ++i) {
            result[i] = value.GetDouble(i);
            if (!std::isfinite(result[i]))
                refuse("not a finite number", file, tag);
        }
        return result;
    }

    double optional_number(vtkDICOMMetaData* data, const fs::path& file, vtkDICOMTag tag, double otherwise)
    {
        const vtkDICOMValue& value = data->Get(tag);
        return value.IsValid() && value.GetNumberOfValues() > 0 ? numbers(data, file, tag, 1)[0] : otherwise;
    }

    Slice read_tags(const fs::path& file)
    {
        vtkNew<vtkDICOMMetaData> data;
        vtkNew<vtkDICOMParser> parser;
        const ErrorCollector errors(parser);
        parser->SetFileName(file.string().c_str());
        parser->SetMetaData(data);
        parser->Update();
        if (errors.failed() || parser->GetErrorCode() != 0)
            throw InputError("damaged DICOM file", file.string());

        Slice slice;
        slice.file = file;
        slice.series = data->Get(DC::SeriesInstanceUID).AsString();
        slice.description = data->Get(DC::SeriesDescription).AsString();
        if (!parser->GetPixelDataFound() || parser->GetPixelDataVL() == 0)
            refuse("the file has no pixels", file, DC::PixelData);
        if (data->Get(DC::NumberOfFrames).IsValid() && data->Get(DC::NumberOfFrames).AsInt() > 1)
            refuse("several frames in one file are not supported: export the series as one file per slice", file,
                DC::NumberOfFrames);
        if (optional_number(data, file, DC::SamplesPerPixel, 1) != 1)
            refuse("a CT slice has one sample per pixel, this is a colour image", file, DC::SamplesPerPixel);
        slice.columns = static_cast<int>(numbers(data, file, DC::Columns, 1)[0]);
        slice.rows = static_cast<int>(numbers(data, file, DC::Rows, 1)[0]);
        const auto position = numbers(data, file, DC::ImagePositionPatient, 3);
        const auto orientation = numbers(data, file, DC::ImageOrientationPatient, 6);
        const auto spacing = numbers(data, file, DC::PixelSpacing, 2);
        slice.position = { position[0], position[1], position[2] };
        slice.row = { orientation[0], orientation[1], orientation[2] };
        slice.column = { orientation[3], orientation[4], orientation[5] };
        slice.row_spacing = spacing[0];
        slice.column_spacing = spacing[1];
        if (slice.row_spacing <= 0.0 || slice.column_spacing <= 0.0)
            refuse("pixel spacing must be positive", file, DC::PixelSpacing);
        constexpr double kUnitTolerance = 1e-3; // some scanners write five digits
        if (std::abs(slice.row.norm() - 1.0) > kUnitTolerance || std::abs(slice.column.norm() - 1.0) > kUnitTolerance
            || std::abs(slice.row.dot(slice.column)) > kUnitTolerance)
            refuse("row and column directions must be perpendicular unit vectors", file, DC::ImageOrientationPatient);
        slice.thickness = optional_number(data, file, DC::SliceThickness, 0.0);
        slice.slope = optional_number(data, file, DC::RescaleSlope, 1.0);
        slice.intercept = optional_number(data, file, DC::RescaleIntercept, 0.0);
        if (slice.slope == 0.0)
            refuse("a rescale slope of zero leaves no image", file, DC::RescaleSlope);
        return slice;
    }

    std::vector<fs::path> dicom_files(const fs::path& folder)
    {
        std::error_code error;
        if (!fs::is_directory(folder, error))
            throw IoError("not a folder", folder.string());
        std::vector<fs::path> files;
        fs::directory_iterator it(folder, error);
        if (error)
            throw IoError("cannot list the folder: " + error.message(), folder.string());
        for (const auto& entry : it)
            if (entry.is_regular_file() && vtkDICOMUtilities::IsDICOMFile(entry.path().string().c_str())
                && entry.path().filename() != "DICOMDIR")
                files.push_back(entry.path());
        std::sort(files.begin(), files.end());
        return files;
    }

    void check_one_series(const std::vector<Slice>& slices, const fs::path& folder)
    {
        std::map<std::string, std::pair<std::size_t, std::string>> series;
        for (const Slice& slice : slices) {
            auto& [count, description] = series[slice.series];
            ++count;
            description = slice.description;
        }
        if (series.size() == 1)
            return;
        std::string names;
        for (const auto& [uid, what] : series)
            names += "\n  " + uid + " (" + std::to_string(what.first) + " files, \"" + what.second + "\")";
        throw InputError("the folder holds " + std::to_string(series.size())
                + " series; put the one to read in a folder of its own:" + names,
            folder.string() + " " + tag_name(DC::SeriesInstanceUID));
    }

    void check_alike(const std::vector<Slice>& slices)
    {
        constexpr double kDirectionTolerance = 1e-4;
        constexpr double kSpacingTolerance = 1e-4; // relative
        const Slice& first = slices.front();
        for (const Slice& slice : slices) {
            if (slice.columns != first.columns || slice.rows != first.rows)
                refuse("slices of different sizes: " + std::to_string(slice.columns) + " x "
                        + std::to_string(slice.rows) + " here, " + std::to_string(first.columns) + " x "
                        + std::to_string(first.rows) + " in " + first.file.filename().string(),
                    slice.file, DC::Columns);
            if ((slice.row - first.row).norm() > kDirectionTolerance
                || (slice.column - first.column).norm() > kDirectionTolerance)
                refuse(
                    "slices of different orientations: this one is not parallel to " + first.file.filename().string(),
                    slice.file, DC::ImageOrientationPatient);
            if (std::abs(slice.row_spacing - first.row_spacing) > kSpacingTolerance * first.row_spacing
                || std::abs(slice.column_spacing - first.column_spacing) > kSpacingTolerance * first.column_spacing)
                refuse("slices of different pixel spacing", slice.file, DC::PixelSpacing);
        }
    }

    /// Sorts the slices along the normal and gives the grid they form.
    ImageGrid arrange(std::vector<Slice>& slices)
    {
        constexpr double kEvenness = 0.01; // of the mean gap
        constexpr double kSamePlace = 1e-3; // mm
        const Vec3 row = slices.front().row.normalized();
        const Vec3 column = (slices.front().column - slices.front().column.dot(row) * row).normalized();
        const Vec3 normal = row.cross(column);
        const auto height = [&](const Slice& s) { return s.position.dot(normal); };
        std::sort(slices.begin(), slices.end(), [&](const Slice& a, const Slice& b) { return height(a) < height(b); });
        const Slice& first = slices.front();
        const Slice& last = slices.back();
        const auto gaps = static_cast<double>(slices.size() - 1);
        const double spacing = slices.size() > 1 ? (height(last) - height(first)) / gaps : first.thickness;
        // First of all, since a slice given twice also makes the mean gap wrong.
        for (std::size_t s = 1; s < slices.size(); ++s)
            if (height(slices[s]) - height(slices[s - 1]) < kSamePlace)
                refuse("two slices at the same place: this one and " + slices[s - 1].file.filename().string(),
                    slices[s].file, DC::ImagePositionPatient);
        for (std::size_t s = 1; s < slices.size(); ++s) {
            const double gap = height(slices[s]) - height(slices[s - 1]);
            if (std::abs(gap - spacing) > kEvenness * spacing) {
                std::ostringstream text;
                text << "uneven gaps between slices: " << gap << " mm after " << slices[s - 1].file.filename().string()
                     << ", " << spacing << " mm on average; a slice may be missing";
                refuse(text.str(), slices[s].file, DC::ImagePositionPatient);
            }
            const Vec3 shift = slices[s].position - first.position;
            if ((shift - shift.dot(normal) * normal).norm() > kEvenness * std::max(spacing, 1.0))
                refuse("the slices are shifted against each other (tilted gantry): resample the series first",
                    slices[s].file, DC::ImagePositionPatient);
        }
        if (spacing <= 0.0)
            refuse("a single slice needs a slice thickness", first.file, DC::SliceThickness);
        ImageGrid grid;
        grid.size = { first.columns, first.rows, static_cast<int>(slices.size()) };
        grid.spacing = { first.column_spacing, first.row_spacing, spacing };
        grid.origin = first.position;
        grid.direction << row, column, normal;
        check_grid(grid);
        return grid;
    }

    /// Hounsfield units of one slice, row by row from the first as in the file.
    void read_pixels(const Slice& slice, std::span<std::int16_t> out)
    {
        vtkNew<vtkDICOMReader> reader;
        const ErrorCollector errors(reader);
        reader->SetFileName(slice.file.string().c_str());
        reader->SortingOff();
        reader->AutoRescaleOff();
        reader->SetMemoryRowOrderToFileNative();
        reader->Update();
        vtkDataArray* pixels = reader->GetOutput()->GetPointData()->GetScalars();
        if (errors.failed() || reader->GetErrorCode() != 0 || pixels == nullptr
            || pixels->GetNumberOfValues() != static_cast<vtkIdType>(out.size()))
            refuse("the pixels cannot be read (truncated, or an unsupported compression)", slice.file, DC::PixelData);
        for (std::size_t i = 0; i < out.size(); ++i)
            out[i] = to_hounsfield(slice.slope * pixels->GetComponent(static_cast<vtkIdType>(i), 0) + slice.intercept,
                slice.file.string());
    }

} // namespace

Volume read_dicom_series(const fs::path& folder, const Job& job)
{
    const Stopwatch watch;
    std::vector<Slice> slices;
    for (const fs::path& file : dicom_files(folder))
        slices.push_back(read_tags(file));
    if (slices.empty())
        throw InputError("no DICOM files in this folder", folder.string());
    check_one_series(slices, folder);
    check_alike(slices);

    Volume volume;
    volume.grid = arrange(slices);
    volume.voxels.resize(volume.grid.voxel_count());
    const std::size_t slice_size = volume.voxels.size() / slices.size();
    for (std::size_t s = 0; s < slices.size(); ++s) {
        if (job.cancelled())
            return {};
        read_pixels(slices[s], std::span(volume.voxels).subspan(s * slice_size, slice_size));
        job.report("read CT", static_cast<double>(s + 1) / static_cast<double>(slices.size()));
    }
    record_part(job, "voxels", watch, volume.voxels.size() * sizeof(std::int16_t));
    return volume;
}

} // namespace retractor
