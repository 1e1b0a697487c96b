#pragma once
// Pixels of a series to Hounsfield units, several files at a time.

#include "datasets/dicom/dicom_values.h"
#include "mesh/base/job.h"

namespace retractor::datasets {

/// What is checked without decoding: an image of one 8- or 16-bit sample, and as many bytes as it needs.
/// @throws InputError naming file and tag.
void check_pixel_tags(const DicomFile& file);

/// Fills the voxels of the arrangement's grid, which the caller has sized; nothing useful when cancelled.
/// @throws InputError for pixels that cannot be decoded or do not fit 16 bits.
DicomPixelCounts read_dicom_pixels(const std::vector<DicomFile>& files, const DicomArrangement& stack,
    std::vector<std::int16_t>& voxels, const Job& job);

} // namespace retractor::datasets
