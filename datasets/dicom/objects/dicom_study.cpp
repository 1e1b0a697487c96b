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

    std::string new_uid(const char* root)
    {
        constexpr std::size_t kLongestUid = 100;
        std::array<char, kLongestUid> uid {};
        return dcmGenerateUniqueIdentifier(uid.data(), root);
    }

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

    void put(DcmItem& dataset, const DcmTagKey& tag, const std::string& value)
    {
        const OFCondition done = dataset.putAndInsertOFStringArray(tag, value.c_str());
        check_written(done.good(), done.text(), {});
    }

} // namespace

void check_written(bool good, const char* reason, const fs::path& file)
{
    if (!good)
        throw IoError(std::string("a DICOM object cannot be written: ") + reason, file.string());
}

DicomStudy pseudonymous_study()
{
    std::random_device random;
    constexpr unsigned kNumbers = 1000000;
    const std::string number = formatted("%06u", random() % kNumbers);
    return { .patient_name = "Pseudonym^" + number,
        .patient_id = "RETRACTOR-" + number,
        .study_uid = new_uid(SITE_STUDY_UID_ROOT),
        .study_id = number,
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
    for (const fs::path& file : files_of(path)) {
        DcmFileFormat format;
        if (format.loadFile(OFFilename(file.c_str()), EXS_Unknown, EGL_noChange, DCM_MaxReadLength, ERM_autoDetect)
                .bad())
            continue;
        static_cast<void>(format.convertToUTF8());
        DcmDataset& dataset = *format.getDataset();
        const std::string uid = value_of(dataset, DCM_StudyInstanceUID);
        if (uid.empty())
            continue;
        if (!study.study_uid.empty()) {
            if (uid != study.study_uid)
                throw InputError("the files belong to several studies: give the folder of one series", path.string());
            continue;
        }
        study.study_uid = uid;
        study.patient_name = identity.name;
        study.patient_id = identity.id;
        study.birth_date = value_of(dataset, DCM_PatientBirthDate);
        study.sex = value_of(dataset, DCM_PatientSex);
        study.study_id = value_of(dataset, DCM_StudyID);
        study.study_date = value_of(dataset, DCM_StudyDate);
        study.study_time = value_of(dataset, DCM_StudyTime);
        study.accession_number = value_of(dataset, DCM_AccessionNumber);
        study.referring_physician = value_of(dataset, DCM_ReferringPhysicianName);
        study.description = value_of(dataset, DCM_StudyDescription);
        study.frame_of_reference_uid = value_of(dataset, DCM_FrameOfReferenceUID);
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
    put(dataset, DCM_SpecificCharacterSet, "ISO_IR 192");
    put(dataset, DCM_PatientName, study.patient_name);
    put(dataset, DCM_PatientID, study.patient_id);
    put(dataset, DCM_PatientBirthDate, study.birth_date);
    put(dataset, DCM_PatientSex, study.sex);
    if (study.is_pseudonymous) {
        put(dataset, DCM_PatientIdentityRemoved, "YES");
        put(dataset, DCM_DeidentificationMethod, "Retractor writes pseudonyms");
    }
    put(dataset, DCM_StudyInstanceUID, study.study_uid);
    put(dataset, DCM_StudyID, study.study_id);
    put(dataset, DCM_StudyDate, study.study_date);
    put(dataset, DCM_StudyTime, study.study_time);
    put(dataset, DCM_AccessionNumber, study.accession_number);
    put(dataset, DCM_ReferringPhysicianName, study.referring_physician);
    put(dataset, DCM_StudyDescription, study.description);
    put(dataset, DCM_Modality, modality);
    put(dataset, DCM_SeriesInstanceUID, series.uid);
    put(dataset, DCM_SeriesNumber, std::to_string(series.number));
    put(dataset, DCM_SeriesDescription, series.description);
    put(dataset, DCM_Manufacturer, "Retractor");
    put(dataset, DCM_ConversionType, "WSD"); // made by a workstation
}

void write_object(const fs::path& file, DcmItem& dataset, const char* sop_class_uid, int instance_number)
{
    put(dataset, DCM_SOPClassUID, sop_class_uid);
    put(dataset, DCM_SOPInstanceUID, new_uid(SITE_INSTANCE_UID_ROOT));
    put(dataset, DCM_InstanceNumber, std::to_string(instance_number));
    write_file_atomically(file, [&](const fs::path& temporary) {
        DcmFileFormat format;
        OFCondition done = format.getDataset()->copyFrom(dataset);
        if (done.good())
            done = format.saveFile(OFFilename(temporary.c_str()), EXS_LittleEndianExplicit);
        check_written(done.good(), done.text(), file);
    });
}

} // namespace retractor::datasets
