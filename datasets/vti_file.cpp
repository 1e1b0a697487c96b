#include "datasets/vti_file.h"

#include "mesh/base/error.h"

#include <vtkCallbackCommand.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkExecutive.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkXMLImageDataReader.h>

#include <vtkXMLDataParser.h>

#include <map>

namespace retractor {

namespace {

    /// VTK's complaints, which otherwise only go to the console.
    struct Complaints {
        std::string first;

        static void take(vtkObject*, unsigned long, void* self, void* text)
        {
            auto& complaints = *static_cast<Complaints*>(self);
            if (complaints.first.empty())
                complaints.first = text != nullptr ? static_cast<const char*>(text) : "unknown";
        }
        /// The last line that says something; the rest is source positions.
        void refuse(const std::string& where) const
        {
            if (first.empty())
                return;
            std::string text = first;
            while (!text.empty() && (text.back() == '\n' || text.back() == ' '))
                text.pop_back();
            const std::size_t line = text.find_last_of('\n');
            throw InputError(
                "not a readable .vti: " + (line == std::string::npos ? text : text.substr(line + 1)), where);
        }
    };

    VoxelType type_of(int vtk_type, const std::string& where)
    {
        static const std::map<int, VoxelType> kTypes { { VTK_UNSIGNED_CHAR, VoxelType::uint8 },
            { VTK_CHAR, VoxelType::int8 }, { VTK_SIGNED_CHAR, VoxelType::int8 },
            { VTK_UNSIGNED_SHORT, VoxelType::uint16 }, { VTK_SHORT, VoxelType::int16 },
            { VTK_UNSIGNED_INT, VoxelType::uint32 }, { VTK_INT, VoxelType::int32 },
            { VTK_UNSIGNED_LONG, VoxelType::uint64 }, { VTK_LONG, VoxelType::int64 },
            { VTK_UNSIGNED_LONG_LONG, VoxelType::uint64 }, { VTK_LONG_LONG, VoxelType::int64 },
            { VTK_FLOAT, VoxelType::float32 }, { VTK_DOUBLE, VoxelType::float64 } };
        const auto found = kTypes.find(vtk_type);
        if (found == kTypes.end())
            throw InputError("the .vti's values are no numbers", where);
        return found->second;
    }

    /// Sizes from the extent, before VTK allocates.
    std::array<int, 3> sizes_of(const int* extent, const std::filesystem::path& path)
    {
        // The best of VTK's compressors packs rows of zeros about so.
        constexpr double kMostPacked = 8192.0;
        std::vector<double> sizes;
        for (int a = 0; a < 3; ++a)
            sizes.push_back(static_cast<double>(extent[2 * a + 1]) - static_cast<double>(extent[2 * a]) + 1.0);
        const std::array<int, 3> size = checked_sizes(sizes, path.string());
        if (sizes[0] * sizes[1] * sizes[2] > kMostPacked * static_cast<double>(std::filesystem::file_size(path)))
            throw InputError("the header promises more voxels than the file can hold", path.string());
        return size;
    }

    /// The array that is the image: the one marked as scalars, else the only one.
    vtkDataArray* image_array(vtkImageData& image, const std::string& where)
    {
        vtkPointData* data = image.GetPointData();
        if (data->GetNumberOfArrays() == 0)
            throw InputError(image.GetCellData()->GetNumberOfArrays() > 0
                    ? "the .vti has its values in cells: convert them to point data"
                    : "the .vti has no values",
                where);
        vtkDataArray* array = data->GetScalars();
        if (array == nullptr && data->GetNumberOfArrays() == 1)
            array = data->GetArray(0);
        if (array != nullptr)
            return array;
        std::string names;
        for (int n = 0; n < data->GetNumberOfArrays(); ++n) {
            const char* name = data->GetArrayName(n);
            names += std::string(n == 0 ? "" : ", ") + (name != nullptr ? name : "?");
        }
        throw InputError("the .vti has several arrays and marks none as scalars: " + names, where);
    }

    void set_geometry(ImageHeader& header, vtkImageData& image)
    {
        const int* extent = image.GetExtent();
        Mat3 steps;
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c)
                steps(r, c) = image.GetDirectionMatrix()->GetElement(r, c) * image.GetSpacing()[c];
        for (int c = 0; c < 3; ++c)
            if (!(image.GetSpacing()[c] > 0.0))
                throw InputError("the spacing of the .vti must be positive", header.where);
        set_steps(header.grid, steps, header.where);
        const Vec3 origin(image.GetOrigin()[0], image.GetOrigin()[1], image.GetOrigin()[2]);
        if (!origin.allFinite())
            throw InputError("the origin of the .vti must be finite", header.where);
        header.grid.origin = origin + steps * Vec3(extent[0], extent[2], extent[4]);
    }

} // namespace

ImageHeader read_vti(
    const std::filesystem::path& path, const std::function<void(const ImageHeader&, std::span<const char>)>& take)
{
    ImageHeader header;
    header.where = path.string();
    Complaints complaints;
    const vtkNew<vtkCallbackCommand> observer;
    observer->SetCallback(
        [](vtkObject* o, unsigned long e, void* self, void* text) { Complaints::take(o, e, self, text); });
    observer->SetClientData(&complaints);
    const vtkNew<vtkXMLImageDataReader> reader;
    reader->AddObserver(vtkCommand::ErrorEvent, observer);
    reader->AddObserver(vtkCommand::WarningEvent, observer);
    reader->SetParserErrorObserver(observer);
    reader->SetReaderErrorObserver(observer);
    reader->GetExecutive()->AddObserver(vtkCommand::ErrorEvent, observer); // it says again what the reader said
    reader->SetFileName(header.where.c_str());
    reader->UpdateInformation();
    complaints.refuse(header.where);
    const int* whole = reader->GetOutputInformation(0)->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT());
    if (whole == nullptr)
        throw InputError("not a readable .vti: it has no extent", header.where);
    header.grid.size = sizes_of(whole, path);
    reader->Update();
    complaints.refuse(header.where);
    vtkImageData& image = *reader->GetOutput();
    vtkDataArray& array = *image_array(image, header.where);
    if (array.GetNumberOfComponents() != 1)
        throw InputError(
            "the image must have one number per voxel, it has " + std::to_string(array.GetNumberOfComponents()),
            header.where);
    if (sizes_of(image.GetExtent(), path) != header.grid.size
        || static_cast<std::size_t>(array.GetNumberOfTuples()) != header.grid.voxel_count())
        throw InputError("the .vti is cut short: it has " + std::to_string(array.GetNumberOfTuples())
                + " values, its extent promises " + std::to_string(header.grid.voxel_count()),
            header.where);
    header.store.type = type_of(array.GetDataType(), header.where);
    set_geometry(header, image);
    header.notes.emplace_back("a .vti names no frame and no unit: taken as patient LPS in mm");
    take(header,
        { static_cast<const char*>(array.GetVoidPointer(0)),
            header.grid.voxel_count() * voxel_bytes(header.store.type) });
    return header;
}

} // namespace retractor
