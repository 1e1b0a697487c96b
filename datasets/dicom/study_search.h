#pragma once
// Finds the series of a study: of a folder with its subfolders, as a disc with a DICOMDIR has them, or of one file.

#include "datasets/dicom/dicom.h"

#include <cstddef>
#include <filesystem>
#include <vector>

namespace retractor::datasets {

struct StudySeries {
    std::filesystem::path path; ///< the folder that holds the series, or the file; for read_dicom()
    DicomSeries series; ///< its description names no patient
    std::filesystem::path middle_file; ///< the file in the middle of the series, for a small picture
    std::size_t patient = 1; ///< number of the patient among those of the search, by name and id; neither is kept
};

/// Searches a folder and its subfolders, or one file. CT slices come first, then the other series; more slices first.
/// Links to folders are not followed, so that the search ends. A folder that cannot be read is left out.
/// Patients are numbered in the order of the result. @throws IoError when there is no such path; InputError when no
/// DICOM image is found
std::vector<StudySeries> find_study_series(const std::filesystem::path& path, const Job& job = {});

/// Number of patients of these series.
std::size_t patients_of(const std::vector<StudySeries>& study);

} // namespace retractor::datasets
