#pragma once
// Lists the series of a folder and chooses the series to read. The list contains localizers, captured screens and other
// modalities, so that the user sees everything in the folder. Only an explicit request selects one of these.

#include "datasets/dicom/dicom.h"
#include "datasets/dicom/dicom_tags.h"
#include "mesh/base/job.h"

namespace retractor::datasets {

/// The DICOM files found at a path.
struct DicomFolder {
    std::filesystem::path path; ///< a folder, or one file
    std::vector<DicomFile> files; ///< sorted by name; DICOM files only
};

/// One series with its files.
struct DicomGroup {
    DicomSeries series;
    DicomKind kind = DicomKind::slices; ///< kind shared by the files
    std::vector<DicomFile> files;
};

/// Reads the tags of one file, or of all files of a folder. Stops early when the job is cancelled.
/// @throws IoError when there is no such file or folder; InputError when nothing in it is DICOM.
DicomFolder scan_dicom(const std::filesystem::path& path, const Job& job = {});

/// Sorts files into series; series with most slices come first, then lower numbers. A damaged file joins the series
/// that the file names; without a series, a note reports the damaged file.
/// @throws InputError when there is no image.
std::vector<DicomGroup> group_dicom_series(DicomFolder folder, std::vector<std::string>& notes);

/// Chooses the series to read and appends the decision to `notes`.
/// @param wish see DicomReadOptions::series
/// @param where path for messages
/// @throws InputError, listing the series, when `wish` fits none or several, and when the series is no CT.
DicomGroup choose_dicom_series(
    std::vector<DicomGroup> groups, const std::string& wish, const std::string& where, std::vector<std::string>& notes);

} // namespace retractor::datasets
