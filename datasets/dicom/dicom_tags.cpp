#include "datasets/dicom/dicom_tags.h"

#include "datasets/dicom/dicom_events.h"
#include "datasets/dicom/dicom_nesting.h"
#include "datasets/dicom/patient_words.h"

#include <vtkDICOMMetaData.h>
#include <vtkDICOMParser.h>
#include <vtkDICOMUtilities.h>
#include <vtkDICOMValue.h>
#include <vtkNew.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    struct PhaseTag {
        const char* name;
        vtkDICOMTag tag;
    };
    const std::array<PhaseTag, 15> kPhaseTags { {
        { "TemporalPositionIdentifier", DC::TemporalPositionIdentifier },
        { "TemporalPositionIndex", DC::TemporalPositionIndex },
        { "NominalPercentageOfCardiacPhase", DC::NominalPercentageOfCardiacPhase },
        { "TriggerTime", DC::TriggerTime },
        { "AcquisitionNumber", DC::AcquisitionNumber },
        { "FrameAcquisitionNumber", DC::FrameAcquisitionNumber },
        { "StackID", DC::StackID },
        { "SeriesNumber", DC::SeriesNumber },
        { "ConvolutionKernel", DC::ConvolutionKernel },
        { "KVP", DC::KVP },
        { "ImageType", DC::ImageType },
        { "AcquisitionTime", DC::AcquisitionTime },
        { "ContentTime", DC::ContentTime },
        { "FrameReferenceDateTime", DC::FrameReferenceDateTime },
        { "SliceThickness", DC::SliceThickness },
    } };

    /// The printable text, without the padding that DICOM adds.
    std::string clean(std::string text)
    {
        for (char& c : text)
            if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
                c = ' ';
        const std::size_t first = text.find_first_not_of(' ');
        if (first == std::string::npos)
            return {};
        return text.substr(first, text.find_last_not_of(' ') - first + 1);
    }

    double number(std::string_view text)
    {
        const auto is_pad = [](char c) { return c == ' ' || c == '\0' || c == '+'; };
        while (!text.empty() && is_pad(text.front()))
            text.remove_prefix(1);
        while (!text.empty() && (text.back() == ' ' || text.back() == '\0'))
            text.remove_suffix(1);
        double value = 0.0;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        return error == std::errc() && end == text.data() + text.size() ? value
                                                                        : std::numeric_limits<double>::quiet_NaN();
    }

    /// The numbers of a tag. The text is parsed here, because the library reads "1,5" as 1 and "abc" as 0.
    std::vector<double> numbers(const vtkDICOMValue& value)
    {
        constexpr std::size_t kMost = 64; // no tag that is read has more values
        std::vector<double> result;
        if (!value.IsValid())
            return result;
        const vtkDICOMVR vr = value.GetVR();
        if (vr == vtkDICOMVR::FD || vr == vtkDICOMVR::FL || vr == vtkDICOMVR::US || vr == vtkDICOMVR::SS
            || vr == vtkDICOMVR::UL || vr == vtkDICOMVR::SL) {
            for (std::size_t i = 0; i < std::min(value.GetNumberOfValues(), kMost); ++i)
                result.push_back(value.GetDouble(i));
            return result;
        }
        const std::string text = value.AsString();
        if (clean(text).empty())
            return result;
        for (std::size_t start = 0; start <= text.size() && result.size() < kMost;) {
            const std::size_t end = std::min(text.find('\\', start), text.size());
            result.push_back(number(std::string_view(text).substr(start, end - start)));
            start = end + 1;
        }
        return result;
    }

    bool contains_ignoring_case(const std::string& text, const std::string& part)
    {
        const auto same = [](char a, char b) {
            return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
        };
        return std::search(text.begin(), text.end(), part.begin(), part.end(), same) != text.end();
    }

    /// True when text that was typed at the scanner contains the patient's name or id. Long parts of a name also count
    /// inside words.
    bool names_the_patient(const std::string& text, const std::string& name, const std::string& id)
    {
        const std::string folded = fold_case(text);
        const auto holds = [&](const std::string& part) {
            return part.size() >= kShortestTelling && folded.find(part) != std::string::npos;
        };
        const std::vector<std::string> parts = name_parts(fold_case(name));
        return holds(fold_case(id)) || std::any_of(parts.begin(), parts.end(), holds)
            || !telling_parts(text, name).empty();
    }

    DicomKind kind_of(vtkDICOMMetaData* data, const DicomFile& file)
    {
        // An object with rows and columns is an image, even when its pixels are missing.
        if (file.path.filename() == "DICOMDIR" || (!file.has_pixels && (file.rows.empty() || file.columns.empty())))
            return DicomKind::no_image;
        const std::string type = data->Get(DC::ImageType).AsString();
        for (const char* word : { "LOCALIZER", "SCOUT", "TOPOGRAM" })
            if (contains_ignoring_case(type, word))
                return DicomKind::localizer;
        const std::string sop_class = clean(data->Get(DC::SOPClassUID).AsString());
        const std::string secondary_capture = "1.2.840.10008.5.1.4.1.1.7";
        if (sop_class.compare(0, secondary_capture.size(), secondary_capture) == 0
            || contains_ignoring_case(type, "SCREEN SAVE") || contains_ignoring_case(type, "DOSE_INFO"))
            return DicomKind::capture;
        return DicomKind::slices;
    }

    /// True when a group of attributes of frames holds values that are no items. The library takes such values for
    /// items.
    bool frame_groups_damaged(vtkDICOMMetaData* data)
    {
        const auto damaged = [&](vtkDICOMTag tag) {
            const vtkDICOMValue& group = data->Get(tag);
            return group.GetNumberOfValues() > 0 && group.GetSequenceData() == nullptr;
        };
        return damaged(DC::PerFrameFunctionalGroupsSequence) || damaged(DC::SharedFunctionalGroupsSequence);
    }

    DicomFrame read_frame(vtkDICOMMetaData* data, int index)
    {
        const auto get = [&](vtkDICOMTag tag) { return data->Get(0, index, tag); };
        DicomFrame frame;
        frame.position = numbers(get(DC::ImagePositionPatient));
        frame.orientation = numbers(get(DC::ImageOrientationPatient));
        frame.pixel_spacing = numbers(get(DC::PixelSpacing));
        frame.thickness = numbers(get(DC::SliceThickness));
        frame.spacing_between_slices = numbers(get(DC::SpacingBetweenSlices));
        frame.slope = numbers(get(DC::RescaleSlope));
        frame.intercept = numbers(get(DC::RescaleIntercept));
        frame.rescale_type = clean(get(DC::RescaleType).AsString());
        for (const PhaseTag& tag : kPhaseTags)
            frame.phase.push_back(clean(get(tag.tag).AsString()));
        return frame;
    }

    bool overlay_in_pixels(vtkDICOMMetaData* data)
    {
        constexpr int kOverlayGroups = 16;
        for (int g = 0; g < kOverlayGroups; ++g)
            if (data->Get(vtkDICOMTag(static_cast<unsigned short>(0x6000 + 2 * g), 0x0102)).AsInt() > 0)
                return true;
        return false;
    }

    void read_values(DicomFile& file, vtkDICOMMetaData* data)
    {
        const auto text = [&](vtkDICOMTag tag) { return clean(data->Get(tag).AsUTF8String()); };
        const auto many = [&](vtkDICOMTag tag) { return numbers(data->Get(tag)); };
        const std::string name = text(DC::PatientName);
        const std::string id = text(DC::PatientID);
        file.series_uid = text(DC::SeriesInstanceUID);
        file.series_number = text(DC::SeriesNumber);
        file.description = text(DC::SeriesDescription);
        if (names_the_patient(file.description, name, id))
            file.description.clear();
        file.modality = text(DC::Modality);
        file.identity = name + '\n' + id + '\n' + text(DC::StudyInstanceUID) + '\n' + file.series_number + '\n'
            + file.description;
        file.sop_instance = text(DC::SOPInstanceUID);
        file.frame_of_reference = text(DC::FrameOfReferenceUID);
        file.transfer_syntax = text(DC::TransferSyntaxUID);
        file.photometric = text(DC::PhotometricInterpretation);
        file.lossy = text(DC::LossyImageCompression) == "01";
        file.modality_lut = data->Get(DC::ModalityLUTSequence).GetNumberOfValues() > 0;
        file.overlay_in_pixels = overlay_in_pixels(data);
        file.columns = many(DC::Columns);
        file.rows = many(DC::Rows);
        file.samples_per_pixel = many(DC::SamplesPerPixel);
        file.bits_allocated = many(DC::BitsAllocated);
        file.bits_stored = many(DC::BitsStored);
        file.high_bit = many(DC::HighBit);
        file.pixel_representation = many(DC::PixelRepresentation);
        file.padding_value = many(DC::PixelPaddingValue);
        file.padding_limit = many(DC::PixelPaddingRangeLimit);
    }

    /// The number of frames. Returns nothing when the tag holds no valid number, or more frames than the file has
    /// bytes.
    std::optional<int> frame_count(vtkDICOMMetaData* data, std::uint64_t file_size)
    {
        const vtkDICOMValue& value = data->Get(DC::NumberOfFrames);
        const std::vector<double> count = numbers(value);
        if (count.empty())
            return 1;
        constexpr double kMost = 1e5; // a cardiac CT has some thousand frames
        const double most = std::min(kMost, static_cast<double>(file_size));
        if (count.size() != 1 || !(count[0] >= 1.0 && count[0] <= most) || count[0] != std::floor(count[0]))
            return std::nullopt;
        return static_cast<int>(count[0]);
    }

} // namespace

const std::vector<std::string> kDicomPhaseTags = [] {
    std::vector<std::string> names;
    for (const PhaseTag& tag : kPhaseTags)
        names.emplace_back(tag.name);
    return names;
}();

bool is_lossy(const DicomFile& file)
{
    return file.lossy || file.transfer_syntax == "1.2.840.10008.1.2.4.50"
        || file.transfer_syntax == "1.2.840.10008.1.2.4.51" || file.transfer_syntax == "1.2.840.10008.1.2.4.81";
}

std::optional<DicomFile> read_dicom_tags(const fs::path& path)
{
    if (!vtkDICOMUtilities::IsDICOMFile(path.string().c_str()))
        return std::nullopt;
    if (nests_too_deep(path)) {
        DicomFile file;
        file.path = path;
        file.kind = DicomKind::damaged;
        return file;
    }
    vtkNew<vtkDICOMMetaData> data;
    vtkNew<vtkDICOMParser> parser;
    const ErrorCollector errors(parser);
    parser->SetFileName(path.string().c_str());
    parser->SetMetaData(data);
    parser->Update();

    DicomFile file;
    file.path = path;
    read_values(file, data);
    file.file_size = static_cast<std::uint64_t>(std::max<vtkTypeInt64>(parser->GetFileSize(), 0));
    file.pixel_offset = static_cast<std::uint64_t>(std::max<vtkTypeInt64>(parser->GetFileOffset(), 0));
    file.pixel_length = parser->GetPixelDataVL();
    file.has_pixels = parser->GetPixelDataFound() && file.pixel_length > 0;
    const bool failed = errors.failed() || parser->GetErrorCode() != 0;
    file.damaged_pixels = failed && file.has_pixels;
    if (failed && !file.has_pixels) {
        file.kind = DicomKind::damaged;
        return file;
    }
    file.kind = kind_of(data, file);
    if (file.kind == DicomKind::no_image)
        return file;
    const std::optional<int> frames = frame_count(data, file.file_size);
    if (!frames || frame_groups_damaged(data)) {
        file.kind = DicomKind::damaged;
        return file;
    }
    for (int frame = 0; frame < *frames; ++frame)
        file.frames.push_back(read_frame(data, frame));
    return file;
}

} // namespace retractor::datasets
