#include "datasets/dicom/dicom_codecs.h"

#include "mesh/base/error.h"

#include <gdcmFragment.h>
#include <gdcmJPEG2000Codec.h>
#include <gdcmJPEGCodec.h>
#include <gdcmJPEGLSCodec.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>
#include <vtkDICOMImageCodec.h>

#include <algorithm>
#include <array>
#include <exception>
#include <fstream>
#include <memory>

namespace retractor::datasets {

namespace {

    constexpr const char* kJpegFamily = "1.2.840.10008.1.2.4.";
    constexpr const char* kRle = "1.2.840.10008.1.2.5";

    [[noreturn]] void refuse(const std::string& what, const DicomFile& file)
    {
        throw InputError(what, file.path.string() + " PixelData (7fe0,0010)");
    }

    std::uint32_t little_endian(const char* bytes)
    {
        std::uint32_t value = 0;
        for (int b = 3; b >= 0; --b)
            value = value << 8 | static_cast<unsigned char>(bytes[b]);
        return value;
    }

    struct Fragments {
        /// Start of each image, bytes from the first fragment's header; often empty.
        std::vector<std::uint32_t> offsets;
        std::vector<std::uint32_t> places; ///< place of each fragment's header, bytes from the first header
        std::vector<std::vector<char>> bytes;
    };

    Fragments read_fragments(const DicomFile& file)
    {
        constexpr std::uint32_t kItem = 0xE000FFFEU;
        constexpr std::uint32_t kEnd = 0xE0DDFFFEU;
        std::ifstream in(file.path, std::ios::binary);
        std::uint64_t at = file.pixel_offset;
        in.seekg(static_cast<std::streamoff>(at));
        Fragments fragments;
        std::array<char, 8> header {};
        std::uint64_t start = 0;
        for (bool first = true;; first = false) {
            if (!in.read(header.data(), header.size()))
                refuse("the compressed pixels are truncated: their end is missing", file);
            const std::uint32_t tag = little_endian(header.data());
            const std::uint32_t length = little_endian(header.data() + 4);
            const std::uint64_t place = at;
            at += header.size();
            if (tag == kEnd)
                return fragments;
            if (tag != kItem || at + length > file.file_size)
                refuse("the compressed pixels are truncated or damaged", file);
            at += length;
            std::vector<char> bytes(length);
            if (!in.read(bytes.data(), length))
                refuse("the compressed pixels are truncated", file);
            if (first) {
                start = at;
                for (std::size_t b = 0; b + 4 <= bytes.size(); b += 4)
                    fragments.offsets.push_back(little_endian(bytes.data() + b));
                continue;
            }
            fragments.places.push_back(static_cast<std::uint32_t>(place - start));
            fragments.bytes.push_back(std::move(bytes));
        }
    }

    unsigned big_endian(const std::vector<char>& bytes, std::size_t at, int count)
    {
        unsigned value = 0;
        for (int b = 0; b < count; ++b)
            value = value << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(b)]);
        return value;
    }

    /// Size and precision in the header of a code stream.
    struct StreamSize {
        unsigned columns = 0;
        unsigned rows = 0;
        unsigned components = 0;
        unsigned bits = 0;
    };

    /// Reads the size of a JPEG or JPEG-LS stream from its markers up to the start of frame.
    StreamSize jpeg_size(const std::vector<char>& bytes)
    {
        std::size_t at = 2;
        while (at + 10 <= bytes.size() && big_endian(bytes, at, 1) == 0xFF) {
            const unsigned marker = big_endian(bytes, at + 1, 1);
            if (marker == 0xFF) { // fill byte
                ++at;
                continue;
            }
            const bool frame = marker == 0xF7
                || (marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC);
            if (frame)
                return { big_endian(bytes, at + 7, 2), big_endian(bytes, at + 5, 2), big_endian(bytes, at + 9, 1),
                    big_endian(bytes, at + 4, 1) };
            at += 2 + big_endian(bytes, at + 2, 2);
        }
        return {};
    }

    /// Reads the size of a JPEG 2000 stream from the SIZ segment, which comes first.
    StreamSize jpeg2000_size(const std::vector<char>& bytes)
    {
        constexpr std::size_t kSegment = 43;
        if (bytes.size() < kSegment || big_endian(bytes, 0, 4) != 0xFF4FFF51U)
            return {};
        const bool at_origin = big_endian(bytes, 16, 4) == 0 && big_endian(bytes, 20, 4) == 0;
        return { at_origin ? big_endian(bytes, 8, 4) : 0, big_endian(bytes, 12, 4), big_endian(bytes, 40, 2),
            (big_endian(bytes, 42, 1) & 0x7FU) + 1 };
    }

    /// True when the stream ends with its end marker. A zero may follow, which makes the length even.
    bool has_end_marker(const std::vector<char>& bytes)
    {
        constexpr std::size_t kTail = 4;
        for (std::size_t b = bytes.size() > kTail ? bytes.size() - kTail : 0; b + 1 < bytes.size(); ++b)
            if (big_endian(bytes, b, 2) == 0xFFD9)
                return true;
        return false;
    }

    void check_stream(const DicomFile& file, const std::vector<char>& bytes)
    {
        const bool is_2000
            = file.transfer_syntax == "1.2.840.10008.1.2.4.90" || file.transfer_syntax == "1.2.840.10008.1.2.4.91";
        if (bytes.size() < 4 || big_endian(bytes, 0, 2) != (is_2000 ? 0xFF4FU : 0xFFD8U))
            refuse("the compressed pixels are damaged: no start of image", file);
        if (!has_end_marker(bytes))
            refuse("the compressed pixels are truncated: no end of image", file);
        const StreamSize size = is_2000 ? jpeg2000_size(bytes) : jpeg_size(bytes);
        const auto allocated = static_cast<unsigned>(file.bits_allocated[0]);
        if (size.columns != static_cast<unsigned>(file.columns[0]) || size.rows != static_cast<unsigned>(file.rows[0])
            || size.components != 1 || size.bits < 2 || (size.bits <= 8 ? 8U : 16U) != allocated || size.bits > 16)
            refuse("the compressed image is " + std::to_string(size.columns) + " x " + std::to_string(size.rows)
                    + " of " + std::to_string(size.bits) + " bits, the tags say "
                    + std::to_string(static_cast<unsigned>(file.columns[0])) + " x "
                    + std::to_string(static_cast<unsigned>(file.rows[0])) + " of " + std::to_string(allocated),
                file);
    }

    /// Tries the codecs explicitly, because GDCM's own choice ends with a program that writes temporary files.
    bool decode_with_gdcm(const DicomFile& file, const std::vector<char>& compressed, std::vector<char>& out)
    {
        static const bool quiet = [] {
            gdcm::Trace::WarningOff(); // messages of this project replace those of GDCM
            gdcm::Trace::ErrorOff();
            return true;
        }();
        static_cast<void>(quiet);
        const auto stored = static_cast<unsigned short>(file.bits_stored[0]);
        const gdcm::PixelFormat format(1, static_cast<unsigned short>(file.bits_allocated[0]), stored,
            static_cast<unsigned short>(stored - 1), static_cast<unsigned short>(file.pixel_representation[0]));
        const unsigned size[3] = { static_cast<unsigned>(file.columns[0]), static_cast<unsigned>(file.rows[0]), 1 };
        gdcm::Fragment fragment;
        fragment.SetByteValue(compressed.data(), static_cast<std::uint32_t>(compressed.size()));
        const gdcm::SmartPointer<gdcm::SequenceOfFragments> sequence = gdcm::SequenceOfFragments::New();
        sequence->AddFragment(fragment);
        gdcm::DataElement pixels(gdcm::Tag(0x7fe0, 0x0010));
        pixels.SetValue(*sequence);

        const std::string number = file.transfer_syntax.substr(std::string(kJpegFamily).size());
        std::unique_ptr<gdcm::ImageCodec> codec;
        if (number == "80" || number == "81")
            codec = std::make_unique<gdcm::JPEGLSCodec>();
        else if (number == "90" || number == "91")
            codec = std::make_unique<gdcm::JPEG2000Codec>();
        else
            codec = std::make_unique<gdcm::JPEGCodec>();
        codec->SetNumberOfDimensions(2);
        codec->SetDimensions(size);
        codec->SetPlanarConfiguration(0);
        codec->SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
        codec->SetPixelFormat(format);
        codec->SetNeedOverlayCleanup(false);
        gdcm::DataElement decoded;
        if (!codec->Decode(pixels, decoded))
            return false;
        const gdcm::ByteValue* bytes = decoded.GetByteValue();
        if (bytes == nullptr || static_cast<std::size_t>(bytes->GetLength()) < out.size()
            || static_cast<std::size_t>(bytes->GetLength()) > out.size() + 1)
            return false;
        std::copy_n(bytes->GetPointer(), out.size(), out.begin());
        return true;
    }

    bool decode_rle(const DicomFile& file, const std::vector<char>& compressed, std::vector<char>& out)
    {
        vtkDICOMImageCodec::ImageFormat format;
        format.Rows = static_cast<unsigned short>(file.rows[0]);
        format.Columns = static_cast<unsigned short>(file.columns[0]);
        format.BitsAllocated = static_cast<unsigned short>(file.bits_allocated[0]);
        format.BitsStored = static_cast<unsigned short>(file.bits_stored[0]);
        format.PixelRepresentation = static_cast<unsigned short>(file.pixel_representation[0]);
        format.SamplesPerPixel = 1;
        // Number and offsets of the segments; GDCM reads these bytes without checking the size.
        constexpr std::size_t kHeader = 64;
        if (compressed.size() < kHeader)
            return false;
        return vtkDICOMImageCodec(kRle).Decode(format, reinterpret_cast<const unsigned char*>(compressed.data()),
                   compressed.size(), reinterpret_cast<unsigned char*>(out.data()), out.size())
            == vtkDICOMImageCodec::NoError;
    }

} // namespace

bool is_compressed(const DicomFile& file)
{
    return file.transfer_syntax.rfind(kJpegFamily, 0) == 0 || file.transfer_syntax == kRle;
}

std::vector<std::vector<char>> compressed_images(const DicomFile& file)
{
    Fragments fragments = read_fragments(file);
    const std::size_t images = file.frames.size();
    if (fragments.bytes.size() < images)
        refuse("the compressed pixels have " + std::to_string(fragments.bytes.size()) + " fragments for "
                + std::to_string(images) + " images",
            file);
    if (fragments.bytes.size() == images)
        return std::move(fragments.bytes);
    std::vector<std::uint32_t> starts = fragments.offsets;
    if (images == 1)
        starts = { 0 };
    if (starts.size() != images || starts.front() != 0)
        refuse("the compressed pixels do not tell in which of their " + std::to_string(fragments.bytes.size())
                + " fragments an image begins",
            file);
    std::vector<std::vector<char>> result;
    for (std::size_t f = 0; f < fragments.bytes.size(); ++f) {
        if (result.size() < images && fragments.places[f] == starts[result.size()])
            result.emplace_back();
        result.back().insert(result.back().end(), fragments.bytes[f].begin(), fragments.bytes[f].end());
    }
    if (result.size() != images)
        refuse("the table of offsets of the compressed pixels is damaged", file);
    return result;
}

std::vector<char> decode_image(const DicomFile& file, const std::vector<char>& compressed)
{
    const bool rle = file.transfer_syntax == kRle;
    if (!rle)
        check_stream(file, compressed);
    std::vector<char> out(static_cast<std::size_t>(file.columns[0]) * static_cast<std::size_t>(file.rows[0])
        * (static_cast<std::size_t>(file.bits_allocated[0]) / 8));
    bool decoded = false; // the codec's own message does not help a user
    try {
        decoded = rle ? decode_rle(file, compressed, out) : decode_with_gdcm(file, compressed, out);
    } catch (const std::exception&) {
        decoded = false; // the codec's own words say nothing to a user
    }
    if (!decoded)
        refuse("the compressed pixels cannot be decoded: damaged, or an unsupported kind of compression", file);
    return out;
}

} // namespace retractor::datasets
