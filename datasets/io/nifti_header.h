#pragma once
// Reads headers of NIfTI-1 files (.nii, .nii.gz). Format: https://nifti.nimh.nih.gov/nifti-1.

#include "datasets/io/image_header.h"

#include <string>
#include <vector>

namespace retractor::datasets {

/// Reads a header. The grid comes from the sform, or from the qform of a file without sform, and is converted from RAS
/// to LPS and to mm. A file is refused when sform and qform place a corner of the image apart, because nobody can tell
/// which of the two is wrong. A file without both is refused, because left and right cannot be told.
/// @throws InputError naming file and field; IoError when the file cannot be opened.
ImageHeader read_nifti_header(const std::filesystem::path& path);

/// One header extension.
struct NiftiExtension {
    int code = 0; ///< 0 unknown, 2 DICOM, 4 AFNI, 6 comment ...
    std::string bytes; ///< content of the extension
};
/// Reads the header extensions. TotalSegmentator stores its label names in an extension.
/// @pre read_nifti_header() accepts the file.
std::vector<NiftiExtension> read_nifti_extensions(const std::filesystem::path& path);

} // namespace retractor::datasets
