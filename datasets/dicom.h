#pragma once
// CT series in DICOM. Geometry comes from the tags of each slice (Image Position and Orientation, Pixel Spacing),
// values are Hounsfield units after each slice's own rescale. Frame: patient LPS, which is DICOM's.

#include "mesh/base/job.h"
#include "mesh/volume.h"

#include <filesystem>
#include <string>

namespace retractor {

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
void write_dicom_series(const std::filesystem::path& folder, const Volume& volume, const DicomOptions& options = {});

/// Reads the one series in a folder (its subfolders are not searched). Files that are not DICOM are passed over.
/// Slices are sorted along the normal of the image plane, i along a row, j along a column, k along the normal
/// (row x column), so that the result is right-handed whatever the file order. Records the part "voxels".
/// @throws InputError naming file and tag for: no DICOM files, more than one series (named), no pixels, several
/// frames in a file, colour, mixed sizes, spacings or orientations, slices at the same place, uneven gaps, a tilted
/// gantry, values outside 16 bits; IoError when the folder cannot be read.
Volume read_dicom_series(const std::filesystem::path& folder, const Job& job = {});

} // namespace retractor
