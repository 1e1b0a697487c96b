#include "datasets/dicom/objects/document_objects.h"

#include "mesh/base/error.h"

#include <dcmtk/config/osconfig.h> // before the other headers of DCMTK

#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmdata/dcuid.h>

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <vector>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    struct Picture {
        int width = 0, height = 0;
        std::vector<std::uint8_t> rgb; ///< rows from the top
    };

    Picture read_png(const fs::path& png)
    {
        vtkNew<vtkPNGReader> reader;
        if (reader->CanReadFile(png.c_str()) == 0)
            throw IoError("cannot read the picture", png.string());
        reader->SetFileName(png.c_str());
        reader->Update();
        vtkImageData* image = reader->GetOutput();
        const int* size = image->GetDimensions();
        const int channels = image->GetNumberOfScalarComponents();
        if (image->GetScalarType() != VTK_UNSIGNED_CHAR || size[0] < 1 || size[1] < 1)
            throw IoError("the picture has not 8 bits per channel", png.string());
        Picture picture { .width = size[0], .height = size[1], .rgb = {} };
        picture.rgb.reserve(3 * static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]));
        for (int y = size[1] - 1; y >= 0; --y)
            for (int x = 0; x < size[0]; ++x) {
                const auto* pixel = static_cast<const std::uint8_t*>(image->GetScalarPointer(x, y, 0));
                const bool grey = channels < 3;
                constexpr int kOpaque = 255;
                const int alpha = channels == 2 ? pixel[1] : channels == 4 ? pixel[3] : kOpaque;
                for (int c = 0; c < 3; ++c) {
                    const int value = pixel[grey ? 0 : c];
                    picture.rgb.push_back(
                        static_cast<std::uint8_t>((value * alpha + kOpaque * (kOpaque - alpha)) / kOpaque));
                }
            }
        return picture;
    }

    void put_number(DcmItem& dataset, const DcmTagKey& tag, int value, const fs::path& file)
    {
        if (value < 0 || value > std::numeric_limits<Uint16>::max())
            throw IoError("the picture is too large for DICOM", file.string());
        const OFCondition done = dataset.putAndInsertUint16(tag, static_cast<Uint16>(value));
        check_written(done.good(), done.text(), file);
    }

} // namespace

void write_secondary_capture(const fs::path& file, const fs::path& png, const DicomStudy& study,
    const ResultSeries& series, int instance, const std::string& comment)
{
    const Picture picture = read_png(png);
    DcmDataset dataset;
    put_study(dataset, study, series, "OT");
    put_text(dataset, DCM_ConversionType, "WSD", file); // made by a workstation
    put_text(dataset, DCM_ImageType, "DERIVED\\SECONDARY", file);
    put_text(dataset, DCM_PatientOrientation, "", file);
    put_text(dataset, DCM_Laterality, "", file);
    put_text(dataset, DCM_ImageComments, comment, file);
    put_text(dataset, DCM_BurnedInAnnotation, "NO", file);
    put_text(dataset, DCM_PhotometricInterpretation, "RGB", file);
    put_number(dataset, DCM_SamplesPerPixel, 3, file);
    put_number(dataset, DCM_PlanarConfiguration, 0, file);
    put_number(dataset, DCM_Rows, picture.height, file);
    put_number(dataset, DCM_Columns, picture.width, file);
    constexpr int kBits = 8;
    put_number(dataset, DCM_BitsAllocated, kBits, file);
    put_number(dataset, DCM_BitsStored, kBits, file);
    put_number(dataset, DCM_HighBit, kBits - 1, file);
    put_number(dataset, DCM_PixelRepresentation, 0, file);
    std::vector<std::uint8_t> pixels = picture.rgb;
    if (pixels.size() % 2 != 0)
        pixels.push_back(0); // DICOM values have an even length
    const OFCondition done
        = dataset.putAndInsertUint8Array(DCM_PixelData, pixels.data(), static_cast<unsigned long>(pixels.size()));
    check_written(done.good(), done.text(), file);
    write_object(file, dataset, UID_SecondaryCaptureImageStorage, instance);
}

void write_encapsulated_pdf(const fs::path& file, const fs::path& pdf, const DicomStudy& study,
    const ResultSeries& series, const std::string& title)
{
    std::ifstream in(pdf, std::ios::binary);
    std::vector<char> content { std::istreambuf_iterator<char>(in), {} };
    if (!in)
        throw IoError("cannot read the document", pdf.string());
    if (std::string(content.begin(), content.begin() + std::min<std::ptrdiff_t>(5, std::ssize(content))) != "%PDF-")
        throw InputError("this is no PDF", pdf.string());
    const auto length = static_cast<Uint32>(content.size());
    if (content.size() % 2 != 0)
        content.push_back('\0'); // DICOM values have an even length
    DcmDataset dataset;
    put_study(dataset, study, series, "DOC");
    put_text(dataset, DCM_ConversionType, "WSD", file);
    put_text(dataset, DCM_AcquisitionDateTime, "", file);
    put_text(dataset, DCM_BurnedInAnnotation, "NO", file);
    put_text(dataset, DCM_DocumentTitle, title, file);
    OFCondition done = dataset.insertEmptyElement(DCM_ConceptNameCodeSequence);
    check_written(done.good(), done.text(), file);
    put_text(dataset, DCM_MIMETypeOfEncapsulatedDocument, "application/pdf", file);
    done = dataset.putAndInsertUint8Array(DCM_EncapsulatedDocument, reinterpret_cast<const Uint8*>(content.data()),
        static_cast<unsigned long>(content.size()));
    if (done.good())
        done = dataset.putAndInsertUint32(DCM_EncapsulatedDocumentLength, length);
    check_written(done.good(), done.text(), file);
    write_object(file, dataset, UID_EncapsulatedPDFStorage, 1);
}

} // namespace retractor::datasets
