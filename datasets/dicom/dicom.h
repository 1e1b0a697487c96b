#pragma once
// CT series in DICOM. Geometry comes from the tags of each slice (Image Position and Orientation, Pixel Spacing),
// values are Hounsfield units after each slice's own rescale. Frame: patient LPS, which is DICOM's.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace retractor::datasets {

struct DicomOptions {
    std::string patient_name = "Phantom^Retractor"; ///< never a person's: what we write is synthetic or derived
    std::string patient_id = "RETRACTOR-PHANTOM";
    std::string study_description = "Retractor phantom";
    std::string series_description = "Chest CT, synthetic";
};

/// Writes one CT image file per slice (IM0001.dcm ...) with new UIDs. The folder appears whole or not at all; one
/// that exists is replaced when it holds nothing but such files. Positions and directions are
/// written as text with about 11 digits.
/// @throws InputError for a bad grid or sizes that disagree, IoError when the folder holds other files or writing
/// fails.
void write_dicom_series(
    const std::filesystem::path& folder, const mesh::Volume& volume, const DicomOptions& options = {});

/// One series of a folder, from the tags of its files.
struct DicomSeries {
    std::string uid; ///< SeriesInstanceUID, may be empty
    std::string number; ///< SeriesNumber, may be empty
    std::string description;
    std::string modality;
    std::string kind; ///< "localizer" or "secondary capture" for what is no slices, else empty
    std::size_t files = 0;
    std::size_t frames = 0; ///< slices: files, or frames of enhanced multi-frame objects
    std::array<int, 2> columns_rows { 0, 0 };
    bool axial = false; ///< slices square to the patient's long axis to 45 degrees
};

/// The series of a folder (its subfolders are not searched), most slices first. Files that are not DICOM, and DICOM
/// objects without pixels (structured reports, presentation states), are passed over and counted in no series.
/// @throws IoError when the folder cannot be read, InputError when it holds no DICOM image.
std::vector<DicomSeries> list_dicom_series(const std::filesystem::path& folder);

struct DicomReadOptions {
    /// SeriesInstanceUID, SeriesNumber, or "#2" for the second of list_dicom_series(). Empty: the only series, or
    /// the largest axial CT, which a note then names with those that were left.
    std::string series = {};
    /// A tilted gantry: resampled onto a straight grid (a note gives the angle), or refused.
    bool rectify_tilt = true;
};

/// A CT and what was decided while reading it, one line each, for the user. No line holds a patient's name or id.
struct DicomVolume {
    mesh::Volume volume;
    std::vector<std::string> notes;
};

/// Reads one series of a folder, or one file (a single slice with its thickness, or an enhanced multi-frame object).
/// Slices are sorted along the normal of the image plane, i along a row, j along a column, k along the normal
/// (row x column), so that the result is right-handed whatever the file order. Pixels of the PixelPaddingValue (or
/// range) become air (-1024 HU). Records the part "voxels".
/// @throws InputError naming file, tag and positions for: no DICOM image, a series that is not there, no pixels,
/// colour, mixed sizes, spacings or orientations, several slices at one place (4-D phases stacked as one are named as
/// such), uneven gaps and missing slices, values outside 16 bits; IoError when the folder cannot be read.
DicomVolume read_dicom(const std::filesystem::path& path, const DicomReadOptions& options = {}, const Job& job = {});

/// The volume alone, for files that the project wrote itself.
mesh::Volume read_dicom_series(const std::filesystem::path& folder, const Job& job = {});

} // namespace retractor::datasets
