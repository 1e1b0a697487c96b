#include "datasets/io/image_file.h"

#include "mesh/base/error.h"

#include <itkImageIOBase.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

namespace retractor::datasets {

namespace {

    // Makes the writer of each format explicitly, because ITK's factories would try every linked format.
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

    /// The reason in an ITK exception is its last line; the other lines are source positions. The NRRD library puts its
    /// own name and that of a function before it ("[nrrd] function: reason").
    std::string reason(const itk::ExceptionObject& error)
    {
        std::string text = error.GetDescription();
        while (!text.empty() && (text.back() == '\n' || text.back() == ' '))
            text.pop_back();
        if (const std::size_t line = text.find_last_of('\n'); line != std::string::npos)
            text.erase(0, line + 1);
        if (const std::size_t function = text.find(": "); text.starts_with("[nrrd]") && function != std::string::npos)
            text.erase(0, function + 2);
        return text;
    }

} // namespace

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
        io->SetComponentType(image.is_signed ? itk::IOComponentEnum::SHORT : itk::IOComponentEnum::USHORT);
        io->SetNumberOfComponents(1);
        io->SetUseCompression(format != ImageFormat::nifti || path.extension() == ".gz");
        io->SetCompressionLevel(2); // the noise of a CT does not compress, so a higher level only takes time
        io->WriteImageInformation();
        io->Write(bytes);
    } catch (const itk::ExceptionObject& error) {
        throw IoError("cannot write the image: " + reason(error), path.string());
    }
}

} // namespace retractor::datasets
