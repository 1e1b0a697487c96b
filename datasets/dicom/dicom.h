#pragma once
// Reads and writes CT series in DICOM. The geometry comes from the tags of each slice (Image Position, Image
// Orientation, Pixel Spacing). Values are Hounsfield units after the rescale of each slice. The frame is patient LPS,
// as in DICOM; lengths are in mm.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace retractor::datasets {

/// The texts that a written series carries. A person's name must not be among them: the files are synthetic or derived.
struct DicomOptions {
    std::string patient_name = "Phantom^Retractor"; ///< PatientName
    std::string patient_id = "RETRACTOR-PHANTOM"; ///< PatientID
    std::string series_description = "Chest CT, synthetic"; ///< SeriesDescription
};

/// Writes one CT image file per slice (IM0001.dcm ...) with new UIDs. The folder appears complete or not at all. An
/// existing folder is replaced when it holds only files of this kind. Positions and directions are written as text with
/// about 11 digits.
/// @throws InputError for a bad grid or for sizes that disagree; IoError when the folder holds other files or when
/// writing fails.
void write_dicom_series(
    const std::filesystem::path& folder, const mesh::Volume& volume, const DicomOptions& options = {});

/// One series of a folder, as the tags of its files describe the series.
struct DicomSeries {
    std::string uid; ///< SeriesInstanceUID; may be empty
    std::string number; ///< SeriesNumber; may be empty
    std::string description; ///< SeriesDescription
    std::string modality; ///< Modality, "CT" for example
    std::string kind; ///< "localizer" or "secondary capture" for a series without slices, else empty
    std::size_t files = 0; ///< number of files
    std::size_t frames = 0; ///< number of slices: files, or frames of enhanced multi-frame objects
    std::array<int, 2> columns_rows { 0, 0 }; ///< pixels in a row, pixels in a column
    bool axial = false; ///< the slices are perpendicular to the patient's long axis, within 45 degrees
};

/// Lists the series of a folder; the series with most slices comes first. Subfolders are not searched. Files that are
/// not DICOM are skipped. DICOM objects without pixels (structured reports, presentation states) belong to no listed
/// series.
/// @throws IoError when the folder cannot be read; InputError when the folder holds no DICOM image.
std::vector<DicomSeries> list_dicom_series(const std::filesystem::path& folder);

/// How to choose and read a series.
struct DicomReadOptions {
    /// The SeriesInstanceUID, the SeriesNumber, or "#2" for the second entry of list_dicom_series(). Empty chooses the
    /// only series, or else the largest axial CT; a note then names the chosen and the other series.
    std::string series = {};
    /// True resamples the slices of a tilted gantry onto a straight grid, and a note gives the angle. False refuses
    /// them.
    bool rectify_tilt = true;
};

/// A CT and the decisions made while reading the files.
struct DicomVolume {
    mesh::Volume volume;
    std::vector<std::string> notes; ///< one decision each, for the user; no note holds a patient's name or id
};

/// Reads one series of a folder, or one file: a single slice with its thickness, or an enhanced multi-frame object.
/// Index i runs along a row, j along a column, k along the normal of the image plane (row x column). The slices are
/// sorted along this normal, so the grid is right-handed for any order of the files. Pixels with the PixelPaddingValue,
/// or in the padding range, become air (-1024 HU). Records the part "voxels".
/// @throws InputError, naming file, tag and positions, when there is no DICOM image, when the wanted series is missing,
/// for missing pixels, colour images, mixed sizes, spacings or orientations, several slices at one place (the message
/// names 4-D phases that were stacked as one series), uneven gaps, missing slices, and values outside 16 bits; IoError
/// when the folder cannot be read.
DicomVolume read_dicom(const std::filesystem::path& path, const DicomReadOptions& options = {}, const Job& job = {});

/// Reads a series that this project wrote, without notes. @throws as read_dicom() does.
mesh::Volume read_dicom_series(const std::filesystem::path& folder, const Job& job = {});

} // namespace retractor::datasets
