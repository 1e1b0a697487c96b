#pragma once
// Pictures and documents as DICOM objects, for the archive of a hospital.

#include "datasets/dicom/objects/dicom_study.h"

#include <filesystem>
#include <string>

namespace retractor::datasets {

/// Writes a picture as a Secondary Capture image (DICOM PS3.3 A.8.1), RGB.
/// @param png 8 bits per channel; transparency is laid on white
/// @param instance number within the series, from 1
/// @throws IoError when the picture cannot be read or the object cannot be written
void write_secondary_capture(const std::filesystem::path& file, const std::filesystem::path& png,
    const DicomStudy& study, const ResultSeries& series, int instance, const std::string& comment);

/// Writes a document as an Encapsulated PDF (DICOM PS3.3 A.45.1).
/// @throws InputError when `pdf` is no PDF; IoError as above
void write_encapsulated_pdf(const std::filesystem::path& file, const std::filesystem::path& pdf,
    const DicomStudy& study, const ResultSeries& series, const std::string& title);

} // namespace retractor::datasets
