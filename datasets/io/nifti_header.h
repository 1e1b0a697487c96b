#pragma once
// Headers of NIfTI-1 files (.nii, .nii.gz). Format: https://nifti.nimh.nih.gov/nifti-1.

#include "datasets/io/image_header.h"

#include <string>
#include <vector>

namespace retractor::datasets {

/// The grid is the sform's where the file has one, else the qform's, turned from RAS to LPS and into mm.
/// Two that place a corner of the image apart are refused: one of them is wrong, and which is not ours to guess. So is
/// a file that has neither: left and right cannot be told.
/// @throws InputError naming file and field; IoError when it cannot be opened.
ImageHeader read_nifti_header(const std::filesystem::path& path);

/// One header extension: its code (0 unknown, 2 DICOM, 4 AFNI, 6 comment ...) and its bytes.
struct NiftiExtension {
    int code = 0;
    std::string bytes;
};
/// The header extensions of a file that read_nifti_header() accepts; TotalSegmentator keeps its label names in one.
std::vector<NiftiExtension> read_nifti_extensions(const std::filesystem::path& path);

} // namespace retractor::datasets
