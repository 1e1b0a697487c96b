#pragma once
// The series of a folder, and the one that is read. Localizers, captured screens and other modalities are listed, so
// that a user sees what there is, and never chosen by themselves.

#include "datasets/dicom/dicom.h"
#include "datasets/dicom/dicom_tags.h"
#include "mesh/base/job.h"

namespace retractor::datasets {

/// Where DICOM files were looked for.
struct DicomFolder {
    std::filesystem::path path; ///< a folder, or one file
    std::vector<DicomFile> files; ///< sorted by name; no file that is not DICOM
};

/// One series, with its files.
struct DicomGroup {
    DicomSeries series;
    DicomKind kind = DicomKind::slices;
    std::vector<DicomFile> files;
};

/// Reads the tags of a file, or of the files of a folder. Stops early when the job is cancelled.
/// @throws IoError when there is no such file or folder, InputError when nothing in it is DICOM.
DicomFolder scan_dicom(const std::filesystem::path& path, const Job& job = {});

/// Most slices first, then by number. Damaged files stand in the series that they name, else a note tells of them.
/// @throws InputError when there is no image.
std::vector<DicomGroup> group_dicom_series(DicomFolder folder, std::vector<std::string>& notes);

/// The series to read (see DicomReadOptions::series); what was decided goes to `notes`.
/// @throws InputError listing the series when the wish fits none or several, and for what is no CT.
DicomGroup choose_dicom_series(
    std::vector<DicomGroup> groups, const std::string& wish, const std::string& where, std::vector<std::string>& notes);

} // namespace retractor::datasets
