#pragma once
// The patient and the study under which results are written as DICOM objects.

#include "mesh/base/geometry.h"

#include <filesystem>
#include <string>

class DcmItem;
class DcmTagKey;

namespace retractor::datasets {

/// Values as DICOM writes them, UTF-8. Empty: not known.
struct DicomStudy {
    std::string patient_name {}, patient_id {}, birth_date {}, sex {};
    std::string study_uid {}, study_id {}, study_date {}, study_time {}, accession_number {}, referring_physician {},
        description {};
    std::string frame_of_reference_uid {}; ///< of patient coordinates; objects with the same one lie in the same place
    bool is_pseudonymous = true;
    Vec3 low = Vec3::Zero(), high = Vec3::Zero(); ///< box round the slices of the source series, mm, patient LPS
};

/// A patient and a study that name nobody: new identifiers, and a random number in place of name and id.
DicomStudy pseudonymous_study();

/// Patient, study and frame of reference of a source series, so that the results are filed beside it.
/// @param path a folder with a DICOM series, or one file of it; subfolders are not searched
/// @throws InputError when there is no DICOM file, when the files name several patients, studies, series or frames of
/// reference, or give no study; IoError when the folder cannot be read. No message holds a name or an id of a person.
DicomStudy study_of_series(const std::filesystem::path& path);

/// A series of results within a study.
struct ResultSeries {
    std::string uid;
    int number = 1;
    std::string description;
};

/// @param number distinguishes the series of a study; those of results begin at kFirstResultSeries
ResultSeries new_series(int number, std::string description);
inline constexpr int kFirstResultSeries = 9001;

/// A new identifier. @param root one of SITE_..._UID_ROOT of DCMTK
std::string new_uid(const char* root);

/// Sets a text. @throws IoError when the library refuses it
void put_text(DcmItem& dataset, const DcmTagKey& tag, const std::string& value, const std::filesystem::path& file = {});

/// Writes patient, study, series, equipment and the time of writing, which all objects share, into a dataset.
/// @param modality "OT", "DOC", "SEG"
/// @throws IoError when the library refuses a value
void put_study(DcmItem& dataset, const DicomStudy& study, const ResultSeries& series, const std::string& modality);

/// Writes a finished dataset in one step, with a new instance identifier.
/// @throws IoError
void write_object(const std::filesystem::path& file, DcmItem& dataset, const char* sop_class_uid, int instance_number);

/// @throws IoError with the library's reason when `good` is false
void check_written(bool good, const char* reason, const std::filesystem::path& file);

} // namespace retractor::datasets
