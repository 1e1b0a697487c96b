#include "datasets/dicom/dicom_codecs.h"
#include "datasets/dicom/dicom_pixels.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace retractor::datasets {

namespace {

    constexpr std::uint32_t kUndefinedLength = 0xFFFFFFFFU;

    double one(const std::vector<double>& values, const DicomFile& file, const char* tag, double low, double high)
    {
        const std::string where = file.path.string() + " " + tag;
        if (values.size() != 1)
            throw InputError("a CT slice needs one number here, the file has " + std::to_string(values.size()), where);
        if (!(values[0] >= low && values[0] <= high) || values[0] != std::floor(values[0]))
            throw InputError(mm_text(values[0]) + " is outside " + mm_text(low) + " to " + mm_text(high), where);
        return values[0];
    }

    void refuse(const std::string& what, const DicomFile& file)
    {
        throw InputError(what, file.path.string() + " PixelData (7fe0,0010)");
    }

    void check_transfer_syntax(const DicomFile& file)
    {
        static const std::set<std::string> kKnown {
            "", // a file without meta header: the library guesses
            "1.2.840.10008.1.2", // implicit VR
            "1.2.840.10008.1.2.1", // explicit VR
            "1.2.840.10008.1.2.2", // big endian
            "1.2.840.10008.1.2.5", // RLE
            "1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.51", "1.2.840.10008.1.2.4.57", // JPEG
            "1.2.840.10008.1.2.4.70", // JPEG lossless
            "1.2.840.10008.1.2.4.80", "1.2.840.10008.1.2.4.81", // JPEG-LS
            "1.2.840.10008.1.2.4.90", "1.2.840.10008.1.2.4.91", // JPEG 2000
        };
        if (!kKnown.contains(file.transfer_syntax))
            throw InputError("unsupported compression, transfer syntax \"" + file.transfer_syntax + "\"",
                file.path.string() + " TransferSyntaxUID (0002,0010)");
        const bool encapsulated = is_compressed(file);
        if (encapsulated != (file.pixel_length == kUndefinedLength) && !file.transfer_syntax.empty())
            refuse("the pixels are not "
                    + std::string(encapsulated ? "in fragments, as their transfer syntax says"
                                               : "plain, as their transfer syntax says"),
                file);
    }

    void check_sizes(const DicomFile& file)
    {
        check_transfer_syntax(file);
        const double bytes = file.bits_allocated[0] / 8.0;
        const double needed = file.columns[0] * file.rows[0] * bytes * static_cast<double>(file.frames.size());
        if (file.pixel_length == kUndefinedLength) {
            // No codec compresses better than this factor. A larger size is a damaged number, and the memory must not
            // be allocated.
            constexpr double kMostCompression = 16384.0;
            if (needed > kMostCompression * static_cast<double>(file.file_size))
                refuse("an image of " + mm_text(file.columns[0]) + " x " + mm_text(file.rows[0]) + " cannot be in "
                        + std::to_string(file.file_size) + " bytes",
                    file);
            return;
        }
        const double rest = static_cast<double>(file.file_size) - static_cast<double>(file.pixel_offset);
        const double present = std::min(static_cast<double>(file.pixel_length), rest);
        if (present < needed)
            refuse("the pixels are truncated: " + mm_text(present) + " bytes of " + mm_text(needed), file);
        if (file.pixel_length > needed + 1.0) // one more byte makes the length even
            refuse("more pixels than the size of the image: " + std::to_string(file.pixel_length) + " bytes, "
                    + mm_text(needed) + " expected",
                file);
    }

} // namespace

void check_pixel_tags(const DicomFile& file)
{
    if (file.kind == DicomKind::damaged)
        throw InputError("damaged DICOM file", file.path.string());
    if (!file.has_pixels)
        refuse("the file has no pixels", file);
    if (file.damaged_pixels)
        refuse("the pixels are truncated", file);
    const double samples = file.samples_per_pixel.empty() ? 1.0 : file.samples_per_pixel[0];
    if (samples != 1.0 || file.samples_per_pixel.size() > 1)
        throw InputError("a CT slice has one sample per pixel, this is a colour image",
            file.path.string() + " SamplesPerPixel (0028,0002)");
    if (file.photometric.rfind("MONOCHROME", 0) != 0 && !file.photometric.empty())
        throw InputError("a CT slice is monochrome, this one is \"" + file.photometric + "\"",
            file.path.string() + " PhotometricInterpretation (0028,0004)");
    if (file.modality_lut)
        throw InputError("values given by a table are not supported, only slope and intercept",
            file.path.string() + " ModalityLUTSequence (0028,3000)");
    constexpr double kMostPixels = 65535.0;
    one(file.columns, file, "Columns (0028,0011)", 1.0, kMostPixels);
    one(file.rows, file, "Rows (0028,0010)", 1.0, kMostPixels);
    const double allocated = one(file.bits_allocated, file, "BitsAllocated (0028,0100)", 1.0, 64.0);
    if (allocated != 8.0 && allocated != 16.0)
        throw InputError(mm_text(allocated) + " bits per pixel: a CT has 16 (or 8)",
            file.path.string() + " BitsAllocated (0028,0100)");
    const double stored = one(file.bits_stored, file, "BitsStored (0028,0101)", 1.0, allocated);
    if (!file.high_bit.empty())
        one(file.high_bit, file, "HighBit (0028,0102)", stored - 1.0, stored - 1.0);
    one(file.pixel_representation, file, "PixelRepresentation (0028,0103)", 0.0, 1.0);
    check_sizes(file);
}

} // namespace retractor::datasets
