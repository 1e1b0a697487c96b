#include "datasets/image_file.h"

#include "mesh/base/error.h"

#include <itkImageIOBase.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include <limits>
#include <map>
#include <new>

namespace retractor {

namespace {

    // The reader of each format is made by name: the library's factories would try whatever is linked.
    itk::ImageIOBase::Pointer make_io(ImageFormat format)
    {
        switch (format) {
        case ImageFormat::nifti:
            return itk::NiftiImageIO::New().GetPointer();
        case ImageFormat::nrrd:
            return itk::NrrdImageIO::New().GetPointer();
        default:
            return itk::MetaImageIO::New().GetPointer();
        }
    }

    /// The last line of an ITK exception says what; the rest is source positions.
    std::string reason(const itk::ExceptionObject& error)
    {
        std::string text = error.GetDescription();
        while (!text.empty() && (text.back() == '\n' || text.back() == ' '))
            text.pop_back();
        const std::size_t line = text.find_last_of('\n');
        return line == std::string::npos ? text : text.substr(line + 1);
    }

    VoxelType voxel_type(itk::IOComponentEnum type, const std::string& where)
    {
        using Type = itk::IOComponentEnum;
        static const std::map<Type, VoxelType> kTypes { { Type::UCHAR, VoxelType::uint8 },
            { Type::CHAR, VoxelType::int8 }, { Type::USHORT, VoxelType::uint16 }, { Type::SHORT, VoxelType::int16 },
            { Type::UINT, VoxelType::uint32 }, { Type::INT, VoxelType::int32 }, { Type::ULONG, VoxelType::uint64 },
            { Type::LONG, VoxelType::int64 }, { Type::ULONGLONG, VoxelType::uint64 },
            { Type::LONGLONG, VoxelType::int64 }, { Type::FLOAT, VoxelType::float32 },
            { Type::DOUBLE, VoxelType::float64 } };
        const auto found = kTypes.find(type);
        if (found == kTypes.end())
            throw InputError("unknown voxel type", where);
        return found->second;
    }

    void check_shape(const itk::ImageIOBase& io, const std::string& where)
    {
        const unsigned dimensions = io.GetNumberOfDimensions();
        bool solid = dimensions >= 3;
        for (unsigned d = 3; d < dimensions; ++d)
            solid = solid && io.GetDimensions(d) == 1;
        if (!solid)
            throw InputError(
                "the image must be three-dimensional, it has " + std::to_string(dimensions) + " dimensions", where);
        if (io.GetNumberOfComponents() != 1)
            throw InputError(
                "the image must have one number per voxel, it has " + std::to_string(io.GetNumberOfComponents()),
                where);
        for (unsigned d = 0; d < 3; ++d)
            if (io.GetDimensions(d) > static_cast<itk::SizeValueType>(std::numeric_limits<int>::max()))
                throw InputError("the image is too large", where);
    }

    ImageFile read_with(itk::ImageIOBase& io, const std::string& where)
    {
        io.SetFileName(where);
        if (!io.CanReadFile(where.c_str()))
            throw InputError("not an image of the kind that its name promises", where);
        io.ReadImageInformation();
        check_shape(io, where);
        ImageFile image;
        std::size_t voxels = 1;
        for (unsigned axis = 0; axis < 3; ++axis) {
            image.size[axis] = static_cast<int>(io.GetDimensions(axis));
            image.spacing[axis] = io.GetSpacing(axis);
            image.origin[axis] = io.GetOrigin(axis);
            const std::vector<double> direction = io.GetDirection(axis);
            for (unsigned r = 0; r < 3; ++r)
                image.axes[axis][r] = direction[r];
            voxels *= io.GetDimensions(axis);
        }
        itk::ImageIORegion region(io.GetNumberOfDimensions());
        for (unsigned d = 0; d < io.GetNumberOfDimensions(); ++d)
            region.SetSize(d, io.GetDimensions(d));
        io.SetIORegion(region);
        image.type = voxel_type(io.GetComponentType(), where);
        const auto bytes = static_cast<std::size_t>(io.GetImageSizeInBytes());
        if (bytes != voxels * io.GetComponentSize())
            throw InputError("the header's sizes disagree", where);
        image.bytes.resize(bytes);
        io.Read(image.bytes.data());
        return image;
    }

} // namespace

ImageFile read_image_file(const std::filesystem::path& path, ImageFormat format)
{
    const std::string where = path.string();
    try {
        return read_with(*make_io(format), where);
    } catch (const itk::ExceptionObject& error) {
        throw InputError("cannot read the image: " + reason(error), where);
    } catch (const std::bad_alloc&) {
        throw InputError("the header promises more voxels than there is memory", where);
    } catch (const std::length_error&) {
        throw InputError("the header promises more voxels than there is memory", where);
    }
}

void write_image_file(const std::filesystem::path& path, ImageFormat format, const ImageFile& image, const void* bytes)
{
    try {
        const auto io = make_io(format);
        io->SetFileName(path.string());
        io->SetNumberOfDimensions(3);
        itk::ImageIORegion region(3);
        for (unsigned axis = 0; axis < 3; ++axis) {
            const auto n = static_cast<itk::SizeValueType>(image.size[axis]);
            io->SetDimensions(axis, n);
            region.SetSize(axis, n);
            io->SetSpacing(axis, image.spacing[axis]);
            io->SetOrigin(axis, image.origin[axis]);
            io->SetDirection(axis, std::vector<double>(image.axes[axis].begin(), image.axes[axis].end()));
        }
        io->SetIORegion(region);
        io->SetPixelType(itk::IOPixelEnum::SCALAR);
        io->SetComponentType(
            image.type == VoxelType::int16 ? itk::IOComponentEnum::SHORT : itk::IOComponentEnum::USHORT);
        io->SetNumberOfComponents(1);
        io->SetUseCompression(format != ImageFormat::nifti || path.extension() == ".gz");
        io->SetCompressionLevel(2); // the noise of a CT does not compress: more effort only costs time
        io->WriteImageInformation();
        io->Write(bytes);
    } catch (const itk::ExceptionObject& error) {
        throw IoError("cannot write the image: " + reason(error), path.string());
    }
}

} // namespace retractor
