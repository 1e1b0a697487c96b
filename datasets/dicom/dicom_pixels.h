#pragma once
// Converts the pixels of a series to Hounsfield units, several files at a time.

#include "datasets/dicom/dicom_values.h"
#include "mesh/base/job.h"

namespace retractor::datasets {

/// Checks a file without decoding: the image has one sample of 8 or 16 bits per pixel, and the file has enough bytes.
/// @throws InputError naming file and tag.
void check_pixel_tags(const DicomFile& file);

/// Fills the voxels (HU) of the arrangement's grid. After a cancellation the voxels are incomplete.
/// @pre `voxels` has one entry per voxel of `stack.grid`.
/// @throws InputError for pixels that cannot be decoded or do not fit 16 bits.
DicomPixelCounts read_dicom_pixels(const std::vector<DicomFile>& files, const DicomArrangement& stack,
    std::vector<std::int16_t>& voxels, const Job& job);

} // namespace retractor::datasets
