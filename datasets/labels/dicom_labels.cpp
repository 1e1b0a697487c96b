#include "datasets/labels/dicom_labels.h"

#include "datasets/dicom/dicom_identity.h"
#include "datasets/labels/contour_fill.h"
#include "datasets/labels/segment_layers.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <dcmtk/config/osconfig.h> // before the other headers of DCMTK

#include <dcmtk/dcmdata/dcfilefo.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmfg/fgpixmsr.h>
#include <dcmtk/dcmfg/fgplanor.h>
#include <dcmtk/dcmfg/fgplanpo.h>
#include <dcmtk/dcmfg/fgseg.h>
#include <dcmtk/dcmrt/drtstrct.h>
#include <dcmtk/dcmseg/segdoc.h>
#include <dcmtk/dcmseg/segment.h>
#include <dcmtk/dcmseg/segutils.h>
#include <dcmtk/oflog/oflog.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    constexpr double kSamePlace = 0.05; ///< share of a plane's spacing by which planes may be off
    constexpr double kSameDirection = 1e-4;
    constexpr double kSameFrameMm = 1e-3; ///< frames of one plane name the same position
    constexpr double kContourPixelMm = 1.0; ///< grid on which contours are filled
    constexpr double kContourMarginMm = 2.0;
    constexpr double kFlatMm = 0.1; ///< a contour stays within this of its plane
    constexpr double kMostVoxels = 4e8; ///< as merge_masks() has it

    void silence_library() { OFLog::configure(OFLogger::OFF_LOG_LEVEL); }

    /// The dataset of a DICOM file, with or without the usual header; null where it cannot be read.
    std::unique_ptr<DcmFileFormat> load(const fs::path& file)
    {
        silence_library();
        // Without a header the library would take any file for DICOM.
        const bool has_header = [&] {
            std::ifstream in(file, std::ios::binary);
            std::array<char, 132> start {};
            in.read(start.data(), start.size());
            return in && std::string_view(start.data() + 128, 4) == "DICM";
        }();
        if (!has_header && !holds_dicom(file))
            return nullptr;
        auto format = std::make_unique<DcmFileFormat>();
        const OFCondition read = format->loadFile(OFFilename(file.c_str()), EXS_Unknown, EGL_noChange,
            DCM_MaxReadLength, has_header ? ERM_fileOnly : ERM_autoDetect);
        if (read.bad())
            return nullptr;
        static_cast<void>(format->convertToUTF8()); // fails where the file names no character set that is known
        return format;
    }

    /// A name as UTF-8. What is none is written by another character set, which the file does not name.
    std::string readable_name(const OFString& name)
    {
        std::string text = name.c_str();
        try {
            static_cast<void>(nlohmann::json(text).dump()); // refuses what is not UTF-8
        } catch (const nlohmann::json::type_error&) {
            std::ranges::replace_if(
                text, [](char c) { return static_cast<unsigned char>(c) >= 0x80; }, '_');
        }
        return text;
    }

    std::string kind_of(DcmFileFormat& format)
    {
        OFString kind;
        format.getDataset()->findAndGetOFString(DCM_SOPClassUID, kind);
        return kind.c_str();
    }

    [[noreturn]] void refuse(const std::string& what, const fs::path& file) { throw InputError(what, file.string()); }

    /// Parallel planes at equal distances.
    struct Planes {
        std::vector<double> at; ///< along the normal, ascending, mm
        double spacing = 1.0;

        int index(double place) const { return static_cast<int>(std::lround((place - at.front()) / spacing)); }
        int count() const { return index(at.back()) + 1; }
    };

    /// @param spacing as the file says; 0: found from the distances, of which some may be several planes
    /// @param same_mm places closer than this are one plane
    Planes planes_of(std::vector<double> places, double spacing, double same_mm, const fs::path& file)
    {
        std::ranges::sort(places);
        Planes planes;
        for (const double place : places)
            if (planes.at.empty() || place - planes.at.back() > same_mm)
                planes.at.push_back(place);
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t n = 1; n < planes.at.size(); ++n)
            least = std::min(least, planes.at[n] - planes.at[n - 1]);
        const double extent = planes.at.back() - planes.at.front();
        if (spacing > 0.0)
            planes.spacing = spacing;
        else if (planes.at.size() > 1)
            planes.spacing = extent / std::round(extent / least);
        for (const double place : planes.at)
            if (std::abs(place - planes.at.front() - planes.index(place) * planes.spacing)
                > kSamePlace * planes.spacing + same_mm)
                refuse("the planes lie at uneven distances", file);
        return planes;
    }

    void check_size(const mesh::ImageGrid& grid, const fs::path& file)
    {
        if (static_cast<double>(grid.size[0]) * grid.size[1] * grid.size[2] > kMostVoxels)
            refuse("the grid of the labels would have more than 400 million voxels", file);
    }

    // --- segmentations ---

    struct Frame {
        std::size_t number = 0;
        Vec3 position = Vec3::Zero();
    };

    template <class Group>
    Group& group_of(
        FGInterface& groups, std::size_t frame, DcmFGTypes::E_FGType type, const char* what, const fs::path& file)
    {
        auto* group = dynamic_cast<Group*>(groups.get(static_cast<Uint32>(frame), type));
        if (group == nullptr)
            refuse("frame " + std::to_string(frame + 1) + " has no " + what, file);
        return *group;
    }

    Mat3 direction_of(FGInterface& groups, std::size_t frame, const fs::path& file)
    {
        auto& orientation = group_of<FGPlaneOrientationPatient>(
            groups, frame, DcmFGTypes::EFG_PLANEORIENTPATIENT, "orientation", file);
        Vec3 row, column;
        if (orientation.getImageOrientationPatient(row.x(), row.y(), row.z(), column.x(), column.y(), column.z()).bad())
            refuse("frame " + std::to_string(frame + 1) + " has no orientation", file);
        if (std::abs(row.norm() - 1.0) > kSameDirection || std::abs(column.norm() - 1.0) > kSameDirection
            || std::abs(row.dot(column)) > kSameDirection)
            refuse("the orientation of frame " + std::to_string(frame + 1) + " is no pair of right angles", file);
        Mat3 direction;
        direction.col(0) = row.normalized();
        direction.col(1) = (column - column.dot(direction.col(0)) * direction.col(0)).normalized();
        direction.col(2) = direction.col(0).cross(direction.col(1));
        return direction;
    }

    /// The frames of each segment, and the grid in which all of them lie.
    struct FrameGrid {
        mesh::ImageGrid grid;
        Planes planes;
        std::map<std::uint16_t, std::vector<Frame>> frames;
    };

    FrameGrid grid_of(DcmSegmentation& object, DcmDataset& data, const fs::path& file)
    {
        FGInterface& groups = object.getFunctionalGroups();
        FrameGrid found;
        found.grid.direction = direction_of(groups, 0, file);
        auto& measures = group_of<FGPixelMeasures>(groups, 0, DcmFGTypes::EFG_PIXELMEASURES, "pixel spacing", file);
        Float64 between_rows = 0.0, between_columns = 0.0, between_slices = 0.0;
        if (measures.getPixelSpacing(between_rows, 0).bad() || measures.getPixelSpacing(between_columns, 1).bad())
            refuse("the object has no pixel spacing", file);
        if (measures.getSpacingBetweenSlices(between_slices).bad())
            between_slices = 0.0;
        std::vector<double> places;
        for (std::size_t n = 0; n < object.getNumberOfFrames(); ++n) {
            if ((direction_of(groups, n, file) - found.grid.direction).norm() > kSameDirection)
                refuse("the frames have different orientations", file);
            auto& position = group_of<FGPlanePosPatient>(groups, n, DcmFGTypes::EFG_PLANEPOSPATIENT, "position", file);
            auto& segment = group_of<FGSegmentation>(groups, n, DcmFGTypes::EFG_SEGMENTATION, "segment", file);
            Frame frame { .number = n };
            Uint16 number = 0;
            if (position.getImagePositionPatient(frame.position.x(), frame.position.y(), frame.position.z()).bad()
                || segment.getReferencedSegmentNumber(number).bad())
                refuse("frame " + std::to_string(n + 1) + " has no position or no segment", file);
            found.frames[number].push_back(frame);
            places.push_back(found.grid.direction.col(2).dot(frame.position));
        }
        found.planes = planes_of(places, between_slices, kSameFrameMm, file);
        Uint16 rows = 0, columns = 0;
        data.findAndGetUint16(DCM_Rows, rows);
        data.findAndGetUint16(DCM_Columns, columns);
        found.grid.size = { columns, rows, found.planes.count() };
        found.grid.spacing = { between_columns, between_rows, found.planes.spacing };
        const Frame& any = found.frames.begin()->second.front();
        const Vec3 normal = found.grid.direction.col(2);
        found.grid.origin = any.position + (found.planes.at.front() - normal.dot(any.position)) * normal;
        for (const auto& [segment, frames] : found.frames)
            for (const Frame& frame : frames) {
                const Vec3 off = frame.position - found.grid.origin;
                if ((off - normal.dot(off) * normal).norm() > kSamePlace * between_columns)
                    refuse("frame " + std::to_string(frame.number + 1) + " is shifted against the others", file);
            }
        return found;
    }

    /// The pixels of the binary frames, eight to a byte without a gap between frames (DICOM PS3.5 8.1.1). DCMTK 3.6.7
    /// itself unpacks frames wrongly whose number of pixels is no multiple of eight.
    std::span<const Uint8> packed_pixels(DcmSegmentation& object, DcmDataset& data)
    {
        const Uint8* bytes = nullptr;
        unsigned long count = 0;
        if (object.getSegmentationType() != DcmSegTypes::ST_BINARY
            || data.findAndGetUint8Array(DCM_PixelData, bytes, &count).bad() || bytes == nullptr)
            return {};
        return { bytes, count };
    }

    /// Sets the voxels of one frame that the segment fills.
    /// @param packed_bits as packed_pixels(); empty: the library unpacks the frame
    void add_frame(DcmSegmentation& object, std::span<const Uint8> packed_bits, const FrameGrid& found,
        const Frame& frame, std::uint16_t most, std::vector<std::uint8_t>& voxels, const fs::path& file)
    {
        const std::size_t pixels
            = static_cast<std::size_t>(found.grid.size[0]) * static_cast<std::size_t>(found.grid.size[1]);
        const int k = found.planes.index(found.grid.direction.col(2).dot(frame.position));
        const std::size_t start = found.grid.offset(0, 0, k);
        if (!packed_bits.empty()) {
            const std::size_t first = frame.number * pixels;
            if ((first + pixels + CHAR_BIT - 1) / CHAR_BIT > packed_bits.size())
                refuse("frame " + std::to_string(frame.number + 1) + " has too few pixels", file);
            for (std::size_t p = 0; p < pixels; ++p)
                if (((packed_bits[(first + p) / CHAR_BIT] >> ((first + p) % CHAR_BIT)) & 1) != 0)
                    voxels[start + p] = 1;
            return;
        }
        const DcmIODTypes::Frame* packed = object.getFrame(frame.number);
        if (packed == nullptr)
            refuse("frame " + std::to_string(frame.number + 1) + " has no pixels", file);
        std::unique_ptr<DcmIODTypes::Frame> unpacked;
        const bool binary = object.getSegmentationType() == DcmSegTypes::ST_BINARY;
        if (binary)
            unpacked.reset(DcmSegUtils::unpackBinaryFrame(
                packed, static_cast<Uint16>(found.grid.size[1]), static_cast<Uint16>(found.grid.size[0])));
        const DcmIODTypes::Frame* values = binary ? unpacked.get() : packed;
        if (values == nullptr || values->length < pixels)
            refuse("frame " + std::to_string(frame.number + 1) + " has too few pixels", file);
        for (std::size_t p = 0; p < pixels; ++p)
            if (binary ? values->pixData[p] != 0 : 2 * values->pixData[p] >= most)
                voxels[start + p] = 1;
    }

    SegmentedImage read_segmentation(DcmFileFormat& format, const fs::path& file, const Job& job)
    {
        DcmSegmentation* raw = nullptr;
        const OFCondition read = DcmSegmentation::loadDataset(*format.getDataset(), raw);
        const std::unique_ptr<DcmSegmentation> object(raw);
        if (read.bad() || object == nullptr)
            refuse(std::string("the segmentation is damaged: ") + read.text(), file);
        if (object->getNumberOfFrames() == 0)
            refuse("the segmentation has no frame", file);
        Uint16 most = 1;
        format.getDataset()->findAndGetUint16(DCM_MaximumFractionalValue, most);
        const FrameGrid found = grid_of(*object, *format.getDataset(), file);
        check_size(found.grid, file);
        const std::span<const Uint8> packed = packed_pixels(*object, *format.getDataset());
        SegmentLayers layers(found.grid);
        std::vector<std::string> empty;
        std::vector<std::uint8_t> voxels(found.grid.voxel_count());
        std::size_t done = 0;
        for (const auto& [number, frames] : found.frames) {
            if (job.cancelled())
                return {};
            job.report("read labels", static_cast<double>(done++) / static_cast<double>(found.frames.size()));
            std::ranges::fill(voxels, std::uint8_t { 0 });
            for (const Frame& frame : frames)
                add_frame(*object, packed, found, frame, most, voxels, file);
            OFString name;
            DcmSegment* segment = object->getSegment(number);
            if (segment == nullptr || segment->getSegmentLabel(name).bad() || name.empty())
                name = ("segment " + std::to_string(number)).c_str();
            if (!layers.add("Segment_" + std::to_string(number), readable_name(name), voxels))
                empty.push_back(readable_name(name));
        }
        SegmentedImage image = layers.take();
        if (image.segments.empty())
            refuse("no segment has a voxel", file);
        if (!empty.empty())
            image.notes.push_back("segments without a voxel, left out: " + joined(empty));
        return image;
    }

    // --- structure sets ---

    struct Structure {
        std::string name;
        std::vector<Contour> contours;
    };

    std::map<Sint32, std::string> names_of(DRTStructureSetIOD& object)
    {
        std::map<Sint32, std::string> names;
        DRTStructureSetROISequence& structures = object.getStructureSetROISequence();
        for (OFCondition more = structures.gotoFirstItem(); more.good(); more = structures.gotoNextItem()) {
            Sint32 number = 0;
            OFString name;
            if (structures.getCurrentItem().getROINumber(number).good()
                && structures.getCurrentItem().getROIName(name).good())
                names[number] = readable_name(name);
        }
        return names;
    }

    /// The closed contours of one structure; others (points, open lines) are counted.
    std::vector<Contour> contours_of(DRTContourSequence& sequence, std::size_t& others, const fs::path& file)
    {
        std::vector<Contour> contours;
        for (OFCondition more = sequence.gotoFirstItem(); more.good(); more = sequence.gotoNextItem()) {
            OFString kind;
            OFVector<Float64> numbers;
            DRTContourSequence::Item& item = sequence.getCurrentItem();
            item.getContourGeometricType(kind);
            if (kind.compare(0, 13, "CLOSED_PLANAR") != 0) {
                ++others;
                continue;
            }
            if (item.getContourData(numbers).bad() || numbers.size() % 3 != 0)
                refuse("a contour is damaged", file);
            Contour contour;
            for (std::size_t n = 0; n < numbers.size(); n += 3)
                contour.points.emplace_back(numbers[n], numbers[n + 1], numbers[n + 2]);
            if (contour.points.size() < 3) {
                ++others;
                continue;
            }
            for (const Vec3& point : contour.points)
                if (!point.allFinite() || std::abs(point.z() - contour.points.front().z()) > kFlatMm)
                    refuse("a contour does not lie in an axial plane", file);
            contours.push_back(std::move(contour));
        }
        return contours;
    }

    double mean_height(const Contour& contour)
    {
        double sum = 0.0;
        for (const Vec3& point : contour.points)
            sum += point.z();
        return sum / static_cast<double>(contour.points.size());
    }

    mesh::ImageGrid grid_of(const std::vector<Structure>& structures, const fs::path& file)
    {
        Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
        std::vector<double> places;
        for (const Structure& structure : structures)
            for (const Contour& contour : structure.contours) {
                places.push_back(mean_height(contour));
                for (const Vec3& point : contour.points) {
                    low = low.cwiseMin(point);
                    high = high.cwiseMax(point);
                }
            }
        const Planes planes = planes_of(places, 0.0, kFlatMm, file);
        mesh::ImageGrid grid;
        const Vec3 margin(kContourMarginMm, kContourMarginMm, 0.0);
        grid.origin = low - margin;
        grid.origin.z() = planes.at.front();
        grid.spacing = { kContourPixelMm, kContourPixelMm, planes.spacing };
        const Vec3 extent = (high + margin - grid.origin) / kContourPixelMm;
        if (extent.x() > 1e5 || extent.y() > 1e5)
            refuse("the contours reach over more than 100 m", file);
        grid.size = { static_cast<int>(std::ceil(extent.x())) + 1, static_cast<int>(std::ceil(extent.y())) + 1,
            planes.count() };
        return grid;
    }

    std::vector<Structure> structures_of(DcmFileFormat& format, std::vector<std::string>& notes, const fs::path& file)
    {
        DRTStructureSetIOD object;
        if (const OFCondition read = object.read(*format.getDataset()); read.bad())
            refuse(std::string("the structure set is damaged: ") + read.text(), file);
        const std::map<Sint32, std::string> names = names_of(object);
        std::vector<Structure> structures;
        std::size_t others = 0;
        DRTROIContourSequence& sequence = object.getROIContourSequence();
        for (OFCondition more = sequence.gotoFirstItem(); more.good(); more = sequence.gotoNextItem()) {
            Sint32 number = 0;
            sequence.getCurrentItem().getReferencedROINumber(number);
            Structure structure;
            const auto name = names.find(number);
            structure.name = name != names.end() ? name->second : "structure " + std::to_string(number);
            structure.contours = contours_of(sequence.getCurrentItem().getContourSequence(), others, file);
            if (!structure.contours.empty())
                structures.push_back(std::move(structure));
        }
        if (structures.empty())
            refuse("the structure set has no closed contour", file);
        if (others > 0)
            notes.push_back(std::to_string(others) + " points or open lines were left out");
        return structures;
    }

    SegmentedImage read_structure_set(DcmFileFormat& format, const fs::path& file, const Job& job)
    {
        std::vector<std::string> notes, empty;
        const std::vector<Structure> structures = structures_of(format, notes, file);
        const mesh::ImageGrid grid = grid_of(structures, file);
        check_size(grid, file);
        SegmentLayers layers(grid);
        std::vector<std::uint8_t> voxels(grid.voxel_count());
        for (std::size_t n = 0; n < structures.size(); ++n) {
            if (job.cancelled())
                return {};
            job.report("read labels", static_cast<double>(n) / static_cast<double>(structures.size()));
            std::ranges::fill(voxels, std::uint8_t { 0 });
            for (const Contour& contour : structures[n].contours)
                fill_contour(grid, contour, voxels);
            if (!layers.add("Structure_" + std::to_string(n + 1), structures[n].name, voxels))
                empty.push_back(structures[n].name);
        }
        SegmentedImage image = layers.take();
        if (image.segments.empty())
            refuse("no structure has a voxel", file);
        image.notes = std::move(notes);
        if (!empty.empty())
            image.notes.push_back("structures without a voxel, left out: " + joined(empty));
        return image;
    }

} // namespace

bool is_dicom_labels(const fs::path& file)
{
    std::error_code code;
    if (!fs::is_regular_file(file, code))
        return false;
    const auto format = load(file);
    if (format == nullptr)
        return false;
    const std::string kind = kind_of(*format);
    return kind == UID_SegmentationStorage || kind == UID_RTStructureSetStorage;
}

SegmentedImage read_dicom_labels(const fs::path& file, const Job& job)
{
    const auto format = load(file);
    if (format == nullptr)
        refuse("the file is no DICOM file, or is damaged", file);
    const std::string kind = kind_of(*format);
    if (kind == UID_SegmentationStorage)
        return read_segmentation(*format, file, job);
    if (kind == UID_RTStructureSetStorage)
        return read_structure_set(*format, file, job);
    refuse("the DICOM file holds neither a segmentation nor a structure set", file);
}

} // namespace retractor::datasets
