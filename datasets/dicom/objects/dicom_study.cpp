#include "datasets/dicom/objects/dicom_study.h"

#include "datasets/dicom/dicom_identity.h"
#include "mesh/base/atomic_file.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <dcmtk/config/osconfig.h> // before the other headers of DCMTK

#include <dcmtk/dcmdata/dcfilefo.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmdata/dcuid.h>
#include <dcmtk/oflog/oflog.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <memory>
#include <random>
#include <utility>
#include <vector>

namespace retractor::datasets {

namespace {

    namespace fs = std::filesystem;

    std::string now(const char* format)
    {
        const std::time_t seconds = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
        std::tm parts {};
        localtime_r(&seconds, &parts);
        constexpr std::size_t kRoom = 32;
        std::array<char, kRoom> text {};
        return { text.data(), std::strftime(text.data(), text.size(), format, &parts) };
    }

    std::string value_of(DcmItem& dataset, const DcmTagKey& tag)
    {
        OFString value;
        static_cast<void>(dataset.findAndGetOFStringArray(tag, value));
        return value.c_str();
    }

    std::vector<fs::path> files_of(const fs::path& path)
    {
        if (!fs::is_directory(path))
            return { path };
        std::vector<fs::path> files;
        for (const fs::directory_entry& entry : fs::directory_iterator(path))
            if (entry.is_regular_file())
                files.push_back(entry.path());
        std::ranges::sort(files);
        return files;
    }

    /// Widens the box of a study by the corners of a slice.
    void add_slice(DcmItem& dataset, DicomStudy& study, bool first)
    {
        std::array<double, 3> at {};
        std::array<double, 6> turned { 1.0, 0.0, 0.0, 0.0, 1.0, 0.0 };
        std::array<double, 2> spacing { 1.0, 1.0 };
        for (unsigned long i = 0; i < at.size(); ++i)
            if (dataset.findAndGetFloat64(DCM_ImagePositionPatient, at.at(i), i).bad())
                return;
        for (unsigned long i = 0; i < turned.size(); ++i)
            static_cast<void>(dataset.findAndGetFloat64(DCM_ImageOrientationPatient, turned.at(i), i));
        for (unsigned long i = 0; i < spacing.size(); ++i)
            static_cast<void>(dataset.findAndGetFloat64(DCM_PixelSpacing, spacing.at(i), i));
        Uint16 rows = 0, columns = 0;
        static_cast<void>(dataset.findAndGetUint16(DCM_Rows, rows));
        static_cast<void>(dataset.findAndGetUint16(DCM_Columns, columns));
        const Vec3 corner(at[0], at[1], at[2]);
        const Vec3 along_row = columns * spacing[1] * Vec3(turned[0], turned[1], turned[2]);
        const Vec3 along_column = rows * spacing[0] * Vec3(turned[3], turned[4], turned[5]);
        if (first)
            study.low = study.high = corner;
        for (const Vec3& p : { corner, Vec3(corner + along_row), Vec3(corner + along_column),
                 Vec3(corner + along_row + along_column) }) {
            study.low = study.low.cwiseMin(p);
            study.high = study.high.cwiseMax(p);
        }
    }

} // namespace

std::string new_uid(const char* root)
{
    constexpr std::size_t kLongestUid = 100;
    std::array<char, kLongestUid> uid {};
    return dcmGenerateUniqueIdentifier(uid.data(), root);
}

void put_text(DcmItem& dataset, const DcmTagKey& tag, const std::string& value, const fs::path& file)
{
    const OFCondition done = dataset.putAndInsertOFStringArray(tag, value.c_str());
    check_written(done.good(), done.text(), file);
}

void check_written(bool good, const char* reason, const fs::path& file)
{
    if (!good)
        throw IoError(std::string("a DICOM object cannot be written: ") + reason, file.string());
}

DicomStudy pseudonymous_study()
{
    std::random_device random;
    const std::string number = formatted("%08x%08x", random(), random()); // two patients never share it
    return { .patient_name = "Pseudonym^" + number,
        .patient_id = "RETRACTOR-" + number,
        .study_uid = new_uid(SITE_STUDY_UID_ROOT),
        .study_id = number.substr(0, 8),
        .study_date = now("%Y%m%d"),
        .study_time = now("%H%M%S"),
        .description = "Incision planning",
        .frame_of_reference_uid = new_uid(SITE_INSTANCE_UID_ROOT) };
}

DicomStudy study_of_series(const fs::path& path)
{
    OFLog::configure(OFLogger::OFF_LOG_LEVEL);
    const PatientIdentity identity = read_dicom_identity(path); // refuses several patients and damaged files
    DicomStudy study { .is_pseudonymous = false };
    std::string series;
    for (const fs::path& file : files_of(path)) {
        DcmFileFormat format;
        if (format.loadFile(OFFilename(file.c_str()), EXS_Unknown, EGL_noChange, DCM_MaxReadLength, ERM_autoDetect)
                .bad())
            continue;
        const bool is_text_known = format.convertToUTF8().good();
        DcmDataset& dataset = *format.getDataset();
        const std::string uid = value_of(dataset, DCM_StudyInstanceUID);
        if (uid.empty())
            continue;
        add_slice(dataset, study, study.study_uid.empty());
        const std::string frame = value_of(dataset, DCM_FrameOfReferenceUID),
                          of = value_of(dataset, DCM_SeriesInstanceUID);
        if (!study.study_uid.empty()) {
            if (uid != study.study_uid || of != series || frame != study.frame_of_reference_uid)
                throw InputError(
                    "the files belong to several studies, series or frames of reference: give the folder of one series",
                    path.string());
            continue;
        }
        series = of;
        study.study_uid = uid;
        study.patient_name = identity.name;
        study.patient_id = identity.id;
        study.birth_date = value_of(dataset, DCM_PatientBirthDate);
        study.sex = value_of(dataset, DCM_PatientSex);
        study.study_date = value_of(dataset, DCM_StudyDate);
        study.study_time = value_of(dataset, DCM_StudyTime);
        study.frame_of_reference_uid = frame;
        if (!is_text_known)
            continue; // free text in a character set that nobody names would be garbled
        study.study_id = value_of(dataset, DCM_StudyID);
        study.accession_number = value_of(dataset, DCM_AccessionNumber);
        study.referring_physician = value_of(dataset, DCM_ReferringPhysicianName);
        study.description = value_of(dataset, DCM_StudyDescription);
    }
    if (study.study_uid.empty())
        throw InputError("no file of the series names a study", path.string());
    if (study.frame_of_reference_uid.empty())
        study.frame_of_reference_uid = new_uid(SITE_INSTANCE_UID_ROOT);
    return study;
}

ResultSeries new_series(int number, std::string description)
{
    return { .uid = new_uid(SITE_SERIES_UID_ROOT), .number = number, .description = std::move(description) };
}

void put_study(DcmItem& dataset, const DicomStudy& study, const ResultSeries& series, const std::string& modality)
{
    put_text(dataset, DCM_SpecificCharacterSet, "ISO_IR 192");
    put_text(dataset, DCM_PatientName, study.patient_name);
    put_text(dataset, DCM_PatientID, study.patient_id);
    put_text(dataset, DCM_PatientBirthDate, study.birth_date);
    put_text(dataset, DCM_PatientSex, study.sex);
    if (study.is_pseudonymous) {
        put_text(dataset, DCM_PatientIdentityRemoved, "YES");
        put_text(dataset, DCM_DeidentificationMethod, "Retractor writes pseudonyms");
    }
    put_text(dataset, DCM_StudyInstanceUID, study.study_uid);
    put_text(dataset, DCM_StudyID, study.study_id);
    put_text(dataset, DCM_StudyDate, study.study_date);
    put_text(dataset, DCM_StudyTime, study.study_time);
    put_text(dataset, DCM_AccessionNumber, study.accession_number);
    put_text(dataset, DCM_ReferringPhysicianName, study.referring_physician);
    put_text(dataset, DCM_StudyDescription, study.description);
    put_text(dataset, DCM_Modality, modality);
    put_text(dataset, DCM_SeriesInstanceUID, series.uid);
    put_text(dataset, DCM_SeriesNumber, std::to_string(series.number));
    put_text(dataset, DCM_SeriesDescription, series.description);
    put_text(dataset, DCM_Manufacturer, "Retractor");
    put_text(dataset, DCM_InstanceCreationDate, now("%Y%m%d"));
    put_text(dataset, DCM_InstanceCreationTime, now("%H%M%S"));
    put_text(dataset, DCM_ContentDate, now("%Y%m%d"));
    put_text(dataset, DCM_ContentTime, now("%H%M%S"));
}

void write_object(const fs::path& file, DcmItem& dataset, const char* sop_class_uid, int instance_number)
{
    put_text(dataset, DCM_SOPClassUID, sop_class_uid);
    put_text(dataset, DCM_SOPInstanceUID, new_uid(SITE_INSTANCE_UID_ROOT));
    put_text(dataset, DCM_InstanceNumber, std::to_string(instance_number));
    write_file_atomically(file, [&](const fs::path& temporary) {
        DcmFileFormat format;
        OFCondition done = format.getDataset()->copyFrom(dataset);
        if (done.good())
            done = format.saveFile(OFFilename(temporary.c_str()), EXS_LittleEndianExplicit);
        check_written(done.good(), done.text(), file);
    });
}

} // namespace retractor::datasets
