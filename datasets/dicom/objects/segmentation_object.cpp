#include "datasets/dicom/objects/segmentation_object.h"

#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <dcmtk/config/osconfig.h> // before the other headers of DCMTK

#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmfg/fgfracon.h>
#include <dcmtk/dcmfg/fgpixmsr.h>
#include <dcmtk/dcmfg/fgplanor.h>
#include <dcmtk/dcmfg/fgplanpo.h>
#include <dcmtk/dcmseg/segdoc.h>
#include <dcmtk/dcmseg/segment.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    struct Code {
        const char* begins; ///< with which the label's name begins
        const char* value; ///< SNOMED CT
        const char* meaning;
    };

    /// The first that fits.
    constexpr std::array kCodes {
        Code { "skin", "39937001", "Skin" },
        Code { "fat", "55603005", "Adipose tissue" },
        Code { "intercostal", "71616004", "Muscle" },
        Code { "muscle", "71616004", "Muscle" },
        Code { "lung_left", "44029006", "Left lung" },
        Code { "lung_right", "3341006", "Right lung" },
        Code { "lung", "39607008", "Lung" },
        Code { "trachea", "44567001", "Trachea" },
        Code { "heart", "80891009", "Heart" },
        Code { "aorta", "15825003", "Aorta" },
        Code { "liver", "10200004", "Liver" },
        Code { "rib", "113197003", "Rib" },
        Code { "sternum", "56873002", "Sternum" },
        Code { "clavicle", "51299004", "Clavicle" },
        Code { "scapula", "79601000", "Scapula" },
        Code { "bone", "272673000", "Bone" },
    };

    CodeSequenceMacro code_of(const std::string& label)
    {
        const auto* found
            = std::ranges::find_if(kCodes, [&](const Code& code) { return label.starts_with(code.begins); });
        return found == kCodes.end() ? CodeSequenceMacro("85756007", "SCT", "Tissue")
                                     : CodeSequenceMacro(found->value, "SCT", found->meaning);
    }

    /// A number as a decimal string of DICOM, which has at most 16 characters.
    OFString decimal(double value) { return formatted("%.9g", value).substr(0, 16).c_str(); }

    /// Which slices hold each label.
    std::vector<std::vector<int>> slices_of_labels(const mesh::LabelVolume& labels)
    {
        std::vector<std::vector<int>> slices(mesh::kLabelCount);
        for (int k = 0; k < labels.grid.size[2]; ++k)
            for (std::size_t at = labels.grid.offset(0, 0, k); at < labels.grid.offset(0, 0, k + 1); ++at)
                if (std::vector<int>& of = slices[labels.voxels[at]]; of.empty() || of.back() != k)
                    of.push_back(k);
        return slices;
    }

    class Writer {
    public:
        Writer(const fs::path& file, const mesh::LabelVolume& labels)
            : file_(file)
            , labels_(labels)
        {
            const std::array<int, 3>& size = labels.grid.size;
            if (size[0] > std::numeric_limits<Uint16>::max() || size[1] > std::numeric_limits<Uint16>::max())
                throw InputError("the labels are too large for DICOM", file.string());
            DcmSegmentation* made = nullptr;
            const IODGeneralEquipmentModule::EquipmentInfo equipment("Retractor", "Retractor", "1", RETRACTOR_VERSION);
            const ContentIdentificationMacro content(
                "1", "LABELS", "Labels for incision planning", "Retractor^Program");
            check(DcmSegmentation::createBinarySegmentation(
                made, static_cast<Uint16>(size[1]), static_cast<Uint16>(size[0]), equipment, content));
            object_.reset(made);
        }

        /// The identifiers that the library asks for; write() adds the other values.
        void begin(const DicomStudy& study, const ResultSeries& series)
        {
            check(object_->getStudy().setStudyInstanceUID(study.study_uid.c_str()));
            check(object_->getSeries().setSeriesInstanceUID(series.uid.c_str()));
            check(object_->getSeries().setSeriesNumber(std::to_string(series.number).c_str()));
            check(object_->getFrameOfReference().setFrameOfReferenceUID(study.frame_of_reference_uid.c_str()));
        }

        void put_grid()
        {
            const mesh::ImageGrid& grid = labels_.grid;
            FGPixelMeasures measures;
            check(measures.setPixelSpacing(decimal(grid.spacing.y()) + "\\" + decimal(grid.spacing.x())));
            check(measures.setSliceThickness(decimal(grid.spacing.z())));
            check(measures.setSpacingBetweenSlices(decimal(grid.spacing.z())));
            check(object_->addForAllFrames(measures));
            const Vec3 row = grid.direction.col(0), column = grid.direction.col(1);
            const std::unique_ptr<FGPlaneOrientationPatient> orientation(
                FGPlaneOrientationPatient::createMinimal(decimal(row.x()), decimal(row.y()), decimal(row.z()),
                    decimal(column.x()), decimal(column.y()), decimal(column.z())));
            check(orientation ? object_->addForAllFrames(*orientation) : EC_IllegalParameter);
            const OFString organisation = new_uid(SITE_INSTANCE_UID_ROOT).c_str();
            IODMultiframeDimensionModule& dimensions = object_->getDimensions();
            check(dimensions.addDimensionIndex(
                DCM_ReferencedSegmentNumber, organisation, DCM_SegmentIdentificationSequence, "Segment"));
            check(dimensions.addDimensionIndex(
                DCM_ImagePositionPatient, organisation, DCM_PlanePositionSequence, "Slice"));
        }

        void add(const mesh::LabelInfo& info, const std::vector<int>& slices, bool estimated)
        {
            DcmSegment* segment = nullptr;
            check(DcmSegment::create(segment, info.name.c_str(),
                CodeSequenceMacro("91723000", "SCT", "Anatomical Structure"), code_of(info.name),
                DcmSegTypes::SAT_SEMIAUTOMATIC, "Retractor"));
            if (estimated)
                check(segment->setSegmentDescription("estimated, not seen in the image"));
            Uint16 number = 0;
            check(object_->addSegment(segment, number)); // the object owns it from here on
            for (const int k : slices)
                add_frame(info.id, number, k);
        }

        void write(const DicomStudy& study, const ResultSeries& series)
        {
            if (packed_.size() % 2 != 0)
                packed_.push_back(0); // DICOM values have an even length
            object_->setCheckFGOnWrite(OFFalse); // all frames are made alike above
            object_->setCheckDimensionsOnWrite(OFFalse);
            write_file_atomically(file_, [&](const fs::path& temporary) {
                DcmFileFormat format;
                OFCondition done = object_->writeDataset(*format.getDataset());
                // DCMTK 3.6.7 packs frames wrongly whose number of pixels is no multiple of eight.
                if (done.good())
                    done = format.getDataset()->putAndInsertUint8Array(
                        DCM_PixelData, packed_.data(), static_cast<unsigned long>(packed_.size()));
                check(done);
                put_study(*format.getDataset(), study, series, "SEG");
                if (done.good())
                    done = format.saveFile(OFFilename(temporary.c_str()), EXS_LittleEndianExplicit);
                check(done);
            });
        }

    private:
        void check(const OFCondition& done) const { check_written(done.good(), done.text(), file_); }

        void add_frame(Label label, Uint16 segment, int k)
        {
            const mesh::ImageGrid& grid = labels_.grid;
            std::vector<Uint8> pixels;
            pixels.reserve(grid.offset(0, 0, k + 1) - grid.offset(0, 0, k));
            for (std::size_t at = grid.offset(0, 0, k); at < grid.offset(0, 0, k + 1); ++at)
                pixels.push_back(labels_.voxels[at] == label ? 1 : 0);
            const Vec3 corner = grid.world(Vec3(0.0, 0.0, k));
            const std::unique_ptr<FGPlanePosPatient> position(
                FGPlanePosPatient::createMinimal(decimal(corner.x()), decimal(corner.y()), decimal(corner.z())));
            FGFrameContent content;
            check(position ? EC_Normal : EC_IllegalParameter);
            check(content.setStackID("1"));
            check(content.setInStackPositionNumber(static_cast<Uint32>(k + 1)));
            check(content.setDimensionIndexValues(segment, 0));
            check(content.setDimensionIndexValues(static_cast<Uint32>(k + 1), 1));
            OFVector<FGBase*> groups;
            groups.push_back(position.get());
            groups.push_back(&content);
            check(object_->addFrame(pixels.data(), segment, groups)); // copies
            pack(pixels);
        }

        /// Appends the pixels of a frame, eight to a byte, the first in the lowest bit; frames follow each other
        /// without a gap (DICOM PS3.5 8.1.1).
        void pack(const std::vector<Uint8>& pixels)
        {
            for (const Uint8 pixel : pixels) {
                const std::size_t bit = bits_++ % CHAR_BIT;
                if (bit == 0)
                    packed_.push_back(0);
                packed_.back() = static_cast<Uint8>(packed_.back() | (pixel << bit));
            }
        }

        fs::path file_;
        const mesh::LabelVolume& labels_;
        std::unique_ptr<DcmSegmentation> object_;
        std::vector<Uint8> packed_;
        std::size_t bits_ = 0; ///< pixels in packed_
    };

} // namespace

void write_segmentation(const fs::path& file, const mesh::LabelVolume& labels,
    const std::vector<std::string>& estimated, const DicomStudy& study, const ResultSeries& series)
{
    mesh::check_grid(labels.grid);
    Writer writer(file, labels);
    writer.begin(study, series);
    writer.put_grid();
    const std::vector<std::vector<int>> slices = slices_of_labels(labels);
    bool any = false;
    for (const mesh::LabelInfo& info : labels.table)
        if (info.id != 0 && !slices[info.id].empty()) {
            any = true;
            writer.add(info, slices[info.id], std::ranges::find(estimated, info.name) != estimated.end());
        }
    if (!any)
        throw InputError("no label has a voxel", file.string());
    writer.write(study, series);
}

} // namespace retractor::datasets
